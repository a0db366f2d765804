"""Ray casting in numpy, with a radius cull: every ray against every segment that is near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from xavier_sim.sensors._caster import END_TOLERANCE, PARALLEL, Caster, Floats

MOVED = 0.5
"""How far the robot may move, in metres, before the near segments are looked for again."""

APART = 1.0
"""Metres within which the rays of one cast start."""


class RayCaster(Caster):
    """The caster that needs nothing but numpy.

    Args:
        segments: shape (n, 4), x0, y0, x1, y1 in metres.
        reach: the longest ray, metres.
    """

    def __init__(self, segments: Floats, reach: float) -> None:
        super().__init__(segments, reach)
        self._culled_at: tuple[float, float] | None = None
        self._keep(np.arange(len(segments)))

    def switch(self, index: int, *, on: bool) -> None:
        """Put a segment into the way of rays, or take it out."""
        super().switch(index, on=on)
        self._culled_at = None

    def _cast(
        self, origins: Floats, ux: Floats, uy: Floats, circles: Floats
    ) -> tuple[Floats, Floats]:
        self._cull(float(origins[0, 0]), float(origins[0, 1]))
        hit, cosine = _nearest(*self._meet_segments(origins, ux[:, None], uy[:, None]))
        if len(circles):
            rounds = _nearest(*_meet_circles(origins, ux[:, None], uy[:, None], circles))
            nearer = rounds[0] < hit
            hit = np.where(nearer, rounds[0], hit)
            cosine = np.where(nearer, rounds[1], cosine)
        beyond = ~(hit <= self._reach)
        hit[beyond], cosine[beyond] = np.inf, 1.0
        return hit, cosine

    def _meet_segments(self, origins: Floats, ux: Floats, uy: Floats) -> tuple[Floats, Floats]:
        """All rays against the near segments: distances and cosines, shape (k, near)."""
        wx, wy = self._near_x - origins[:, :1], self._near_y - origins[:, 1:]
        dx, dy = self._near_dx, self._near_dy
        cross = ux * dy - uy * dx
        sine = np.abs(cross) / self._near_length
        askew = sine > PARALLEL
        divisor = np.where(askew, cross, 1.0)
        distance = (wx * dy - wy * dx) / divisor
        share = (wx * uy - wy * ux) / divisor
        met = askew & (distance >= 0.0) & (share >= -END_TOLERANCE)
        met &= share <= 1.0 + END_TOLERANCE
        return np.where(met, distance, np.inf), sine

    def _cull(self, x: float, y: float) -> None:
        """Keep the switched-on segments that a ray from near (x, y) can reach."""
        at = self._culled_at
        if at is None or abs(at[0] - x) + abs(at[1] - y) > MOVED:
            self._culled_at = (x, y)
            reach = self._reach + MOVED + APART
            self._keep(np.flatnonzero(self._on & (self.distances(x, y) <= reach)))

    def _keep(self, near: NDArray[np.intp]) -> None:
        self._near_x, self._near_y = self._start[near].T.copy()
        self._near_dx, self._near_dy = self._along[near].T.copy()
        self._near_length = self._length[near]


def _nearest(distance: Floats, cosine: Floats) -> tuple[Floats, Floats]:
    """The nearest of each row, the first one of several; ``inf`` where there is none."""
    rows = np.arange(len(distance))
    if distance.shape[1] == 0:
        return np.full(len(rows), np.inf), np.ones(len(rows))
    nearest = distance.argmin(axis=1)
    return distance[rows, nearest], cosine[rows, nearest]


def _meet_circles(
    origins: Floats, ux: Floats, uy: Floats, circles: Floats
) -> tuple[Floats, Floats]:
    """All rays against all circles: distances and cosines, shape (k, m)."""
    wx, wy = circles[:, 0] - origins[:, :1], circles[:, 1] - origins[:, 1:]
    radius = circles[:, 2]
    middle = wx * ux + wy * uy
    outside = wx * wx + wy * wy - radius * radius
    half = middle * middle - outside
    chord = np.sqrt(np.maximum(half, 0.0))
    met = (middle > 0.0) & (half >= 0.0)
    distance = np.where(met, middle - chord, np.inf)
    inside = outside <= 0.0
    return np.where(inside, 0.0, distance), np.where(inside, 1.0, chord / radius)
