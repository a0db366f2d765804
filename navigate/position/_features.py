"""What the virtual sensors should report at each location of a floor, and how they err.

A report says of either side whether there is a wall or an opening, how wide, and of the front
whether there is a wall. The same rule that makes reports of echoes makes features of the map:
the share of a stretch of floor, from a little ahead of the robot to a little behind it, in which
nothing stands near beside it. Between the two stands a table of confusions, made by hand as in
Koenig & Simmons (1998).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from navigate.body import AHEAD, BEHIND, BESIDE, FRONT_REACH, STRIP, Front, Side, side_of_share
from navigate.maps import Floats, Floor

RASTER = 0.1
"""Metres along a side of the cells in which walls are looked up."""

OPENED = 0.75
"""Chance that a door is open."""

WITHIN = (-0.4, -0.2, 0.0, 0.2, 0.4)
"""Metres along its way by which a robot in a cell of a metre may be off its middle."""

ASIDE = (-0.3, 0.0, 0.3)
"""Metres across its way by which it may be off."""

BLURRED = 2
"""Raster cells by which a wide cone narrows an opening on either side."""

SIDE_REPORTS: Floats = np.array(
    [
        [0.85, 0.10, 0.04, 0.01],
        [0.27, 0.55, 0.15, 0.03],
        [0.08, 0.25, 0.45, 0.22],
        [0.03, 0.07, 0.22, 0.68],
    ]
)
"""p(report | feature): wall, small, medium and large opening, in this order both ways."""

FRONT_REPORTS: Floats = np.array([[0.80, 0.20], [0.12, 0.88]])
"""p(report | feature): wall, clear."""

SOFTENED = 0.7
"""Exponent of what a report says: those of neighbouring cells share some of their echoes."""


class Features:
    """The chances of reports in each state of the locations ``at``, shape (n, 2), of a floor.

    ``left``, ``right`` have shape (4, n, 4): heading, location, `Side`; ``front`` has shape
    (4, n, 2). They are tempered likelihoods, ready to multiply a belief with.
    """

    def __init__(self, floor: Floor, at: Floats) -> None:
        rasters = [_Raster(floor, shut=shut) for shut in (False, True)]
        self.left = np.stack([_sides(rasters, at, heading, 1) for heading in range(4)])
        self.right = np.stack([_sides(rasters, at, heading, 3) for heading in range(4)])
        self.front = np.stack([_fronts(rasters, at, heading) for heading in range(4)])

    def likelihood(
        self, front: Front | None, left: Side | None, right: Side | None
    ) -> Floats | None:
        """How probable a report is in each state, shape (4 * n,); None when it says nothing."""
        parts = [
            table[:, :, report]
            for table, report in ((self.front, front), (self.left, left), (self.right, right))
            if report is not None
        ]
        return np.prod(parts, axis=0).ravel() if parts else None


class _Raster:
    """How far it is to the next wall from each cell of a floor, in the four directions."""

    def __init__(self, floor: Floor, *, shut: bool) -> None:
        doors = [door.segment() for door in floor.doors.values()] if shut else []
        lines = np.concatenate([floor.walls, np.array(doors).reshape(-1, 4)])
        self._low = lines.reshape(-1, 2).min(axis=0) - 1.0
        size = np.ceil((lines.reshape(-1, 2).max(axis=0) + 1.0 - self._low) / RASTER).astype(int)
        solid = np.zeros(tuple(size), dtype=bool)
        for x0, y0, x1, y1 in (lines - np.tile(self._low, 2)) / RASTER:
            solid[
                int(min(x0, x1)) : int(max(x0, x1)) + 1, int(min(y0, y1)) : int(max(y0, y1)) + 1
            ] = True
        self._reach = [_reaches(solid, axis, back) for axis, back in _AXES]

    def reach(self, points: Floats, heading: int) -> Floats:
        """Metres from points (..., 2) to the next wall in a direction."""
        cells = ((points - self._low) / RASTER).astype(np.intp)
        table = self._reach[heading]
        x = cells[..., 0].clip(0, table.shape[0] - 1)
        y = cells[..., 1].clip(0, table.shape[1] - 1)
        return np.asarray(table[x, y])


_AXES = ((0, False), (1, False), (0, True), (1, True))
_STEPS: Floats = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


def _reaches(solid: NDArray[np.bool_], axis: int, back: bool) -> Floats:
    """Metres from every cell to the next solid one along an axis, 99 where there is none."""
    along = np.moveaxis(solid, axis, 0)
    along = along if back else along[::-1]
    index = np.arange(len(along))[:, None]
    last = np.maximum.accumulate(np.where(along, index, -1000), axis=0)
    metres = np.minimum((index - last) * RASTER, 99.0)
    return np.asarray(np.moveaxis(metres if back else metres[::-1], 0, axis))


def _sides(rasters: list[_Raster], at: Floats, heading: int, aside: int) -> Floats:
    """Tempered chances (n, 4) of reports of the side ``aside`` quarters left of a heading."""
    chances = np.zeros((len(at), len(SIDE_REPORTS)))
    for raster, share in zip(rasters, (OPENED, 1.0 - OPENED), strict=True):
        for across in ASIDE:
            spots = at + across * _STEPS[(heading + 1) % 4]
            gaps = _gaps(raster, spots, heading, (heading + aside) % 4)
            for offset in WITHIN:
                first = round((offset - BEHIND - _FIRST) / STRIP)
                window = gaps[:, first : first + round((AHEAD + BEHIND) / STRIP)]
                features = side_of_share(window.mean(axis=1))
                chances += share / (len(WITHIN) * len(ASIDE)) * SIDE_REPORTS[features]
    return chances**SOFTENED


_FIRST = -BEHIND + min(WITHIN)
_LAST = AHEAD + max(WITHIN)


def _gaps(raster: _Raster, at: Floats, heading: int, aside: int) -> NDArray[np.bool_]:
    """Which strips beside locations are open: (n, strips), from `_FIRST` to `_LAST` metres on."""
    margin = BLURRED * RASTER
    offsets = np.arange(_FIRST - margin, _LAST + margin - 1e-9, STRIP) + STRIP / 2
    points = at[:, None] + offsets[:, None] * _STEPS[heading]
    gaps = raster.reach(points, aside) > BESIDE
    ahead, behind = raster.reach(at, heading), raster.reach(at, (heading + 2) % 4)
    gaps &= (offsets < ahead[:, None]) & (-offsets < behind[:, None])
    blur = np.lib.stride_tricks.sliding_window_view(gaps, 2 * BLURRED + 1, axis=1)
    return np.asarray(blur.all(axis=2))


def _fronts(rasters: list[_Raster], at: Floats, heading: int) -> Floats:
    """Tempered chances (n, 2) of reports of what is ahead."""
    chances = np.zeros((len(at), len(FRONT_REPORTS)))
    for raster, share in zip(rasters, (OPENED, 1.0 - OPENED), strict=True):
        reach = raster.reach(at, heading)
        for offset in WITHIN:
            clear = (reach - offset > FRONT_REACH).astype(int)
            chances += share / len(WITHIN) * FRONT_REPORTS[clear]
    return chances**SOFTENED
