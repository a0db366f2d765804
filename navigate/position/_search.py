"""Looking for a lost robot: which of many poses would hear what is heard now.

In two steps, since the likelihood of a ring of readings has peaks a hand's breadth wide: poses on
a coarse grid in every likely cell, then on a fine one around the best of the best cells. What is
found counts only if it stands out among all cells that were looked at. A search takes some ticks,
a few cells at each, so that none is held up.
"""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

import numpy as np

from navigate.body import BEARINGS, RING_RADIUS, Pose
from navigate.maps import Floats, Point
from navigate.position._expected import Codes, ExpectedRanges, Indices, direction_of
from navigate.position._sonar_model import log_likelihood

FINALISTS = 48
"""Cells that are looked at again on the fine grid."""

COARSE_CELLS, FINE_CELLS = 64, 8
"""Cells that are looked at in a tick."""

TEMPER = 0.35
"""Exponent of the likelihood of a whole ring: its readings err together."""

SAME = 1.0
"""Metres within which two poses that fit are the same."""

LOOKS_ALIKE = 0.7
"""Cosine of the angle between their headings from which they are."""


class Found(NamedTuple):
    """The best pose, and its share among all that might be meant instead, 0 to 1.

    ``fits`` are the log likelihoods of the ring in each of the cells that were looked at, in the
    order in which they were given.
    """

    pose: Pose
    share: float
    fits: Floats


class _Grid(NamedTuple):
    """Poses around the middle of a cell: metres along either axis, and turns in radians."""

    along: Floats
    turns: Floats


_COARSE = _Grid(np.linspace(-0.6, 0.6, 4), np.array([-0.15, 0.0, 0.15]))
_FINE = _Grid(np.linspace(-0.2, 0.2, 5), np.array([-0.08, 0.0, 0.08]))


class Search:
    """A search that goes on a little at each tick, or none."""

    STATE: ClassVar[tuple[str, ...]] = (
        "_cells", "_priors", "_ranges", "_fits", "_done", "_fine", "_order", "_coarse",
        "_finalists",
    )  # fmt: skip

    def __init__(self, expected: ExpectedRanges) -> None:
        self._expected = expected
        self._around: dict[Point, Codes] = {}
        self.stop()

    def stop(self) -> None:
        """Look no more."""
        self._cells: Floats = np.empty((0, 3))
        self._priors: Floats = np.empty(0)
        self._fits: Floats = np.empty(0)
        self._ranges: Floats = np.empty(0)
        self._coarse: Floats = np.empty(0)
        self._order: Indices = np.empty(0, dtype=np.intp)
        self._finalists: Indices = np.empty(0, dtype=np.intp)
        self._done, self._fine = 0, False

    def forget(self) -> None:
        """Keep no more what is to be heard in cells: the robot is not lost any more."""
        self._around.clear()

    @property
    def busy(self) -> bool:
        """Whether a search goes on."""
        return self._done < len(self._cells)

    def begin(self, middles: Floats, mass: Floats, ranges: Floats) -> None:
        """Look for the pose in or around n cells at which a ring of readings would be heard.

        Args:
            middles: poses (n, 3) in the middles of the cells.
            mass: how probable each cell is without the readings, shape (n,).
            ranges: the 24 readings; nothing is found where none of them is an echo.
        """
        self.stop()
        if not np.isfinite(ranges).any():
            return
        nearby = np.lexsort((middles[:, 1], middles[:, 0]))
        self._order = nearby
        self._cells, self._priors = middles[nearby].copy(), np.log(mass[nearby])
        self._ranges, self._fits = ranges, np.zeros(len(middles))

    def go_on(self) -> Found | None:
        """Look at some more cells; what was found, once that was the last of them."""
        if not self.busy:
            return None
        count = FINE_CELLS if self._fine else COARSE_CELLS
        part = slice(self._done, self._done + count)
        poses, fits = self._best(self._cells[part], _FINE if self._fine else _COARSE)
        self._cells[part], self._fits[part] = poses, fits
        self._done += count
        if self.busy:
            return None
        return self._finish() if self._fine else self._refine()

    def _refine(self) -> None:
        """Go on with the best cells, on the fine grid."""
        weights = TEMPER * self._fits + self._priors
        best = np.sort(np.argsort(-weights, kind="stable")[:FINALISTS])
        self._cells, self._priors = self._cells[best], self._priors[best]
        self._coarse, self._finalists = self._fits, best
        self._fits = np.zeros(len(best))
        self._done, self._fine = 0, True

    def _finish(self) -> Found:
        poses, weights = self._cells, TEMPER * self._fits + self._priors
        fits = self._all_fits()
        self.stop()
        shares = np.exp(weights - weights.max())
        winner = poses[int(shares.argmax())]
        near = np.hypot(poses[:, 0] - winner[0], poses[:, 1] - winner[1]) < SAME
        near &= np.cos(poses[:, 2] - winner[2]) > LOOKS_ALIKE
        x, y, theta = winner.tolist()
        pose = (x, y, math.remainder(theta, 2.0 * math.pi))
        return Found(pose, float(shares[near].sum() / shares.sum()), fits)

    def _all_fits(self) -> Floats:
        """Those of all cells: on the fine grid they are better, by as much as a rule in others."""
        gain = self._fits - self._coarse[self._finalists]
        fits = self._coarse + float(gain.mean())
        fits[self._finalists] = self._fits
        given = np.empty_like(fits)
        given[self._order] = fits
        return given

    def _best(self, cells: Floats, grid: _Grid) -> tuple[Floats, Floats]:
        """The best poses around n cells, shape (n, 3), and their log likelihoods, shape (n,)."""
        heard = np.flatnonzero(np.isfinite(self._ranges))
        # What a sonar hears is taken for what would be heard from the robot's middle, farther off.
        readings = self._ranges[heard] + RING_RADIUS
        turned = cells[:, 2, None] + grid.turns
        looks = direction_of(turned[:, :, None] + BEARINGS[heard])
        around = np.stack([self._panorama(x, y, grid) for x, y in cells[:, :2].tolist()])
        spots = np.arange(around.shape[1])
        rows = np.arange(len(cells))[:, None, None, None]
        codes = around[rows, spots[:, None, None], looks[:, None]]
        fits = log_likelihood(readings, codes.reshape(-1, len(heard)).T)
        fits = fits.reshape(len(cells), len(spots), len(grid.turns))
        return _winners(fits, cells, turned, grid)

    def _panorama(self, x: float, y: float, grid: _Grid) -> Codes:
        """What is to be heard in all directions from the points of a grid: (points, directions).

        That of a whole cell is kept: a robot that stays lost looks there again and again.
        """
        if (known := self._around.get((x, y))) is not None and grid is _COARSE:
            return known
        heard = self._expected.panorama(x + grid.along, y + grid.along)
        if grid is _COARSE:
            self._around[x, y] = heard
        return heard


def _winners(fits: Floats, cells: Floats, turned: Floats, grid: _Grid) -> tuple[Floats, Floats]:
    """The poses of the best fits (n, points, turns), and those fits."""
    flat = fits.reshape(len(cells), -1)
    best: Indices = flat.argmax(axis=1)
    spot, turn = np.divmod(best, len(grid.turns))
    across, along = np.divmod(spot, len(grid.along))
    rows = np.arange(len(cells))
    x, y = cells[:, 0] + grid.along[across], cells[:, 1] + grid.along[along]
    return np.column_stack([x, y, turned[rows, turn]]), flat[rows, best]
