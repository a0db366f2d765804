"""Ray casting against wall segments, in numpy, with a radius cull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CULL_MARGIN = 1.0
"""How far the robot may move, in metres, before the near segments are looked for again."""

END_TOLERANCE = 1e-9
"""Share of a segment's length that is added at both ends, so that corners have no gap."""


class RayCaster:
    """Casts rays at the segments of a floor, some of which (doors) can be switched off.

    Args:
        segments: shape (n, 4), x0, y0, x1, y1 in metres.
        reach: the longest ray, metres.
    """

    def __init__(self, segments: Floats, reach: float) -> None:
        self._start = np.ascontiguousarray(segments[:, :2], dtype=np.float64)
        self._along = np.ascontiguousarray(segments[:, 2:] - segments[:, :2], dtype=np.float64)
        self._length = np.hypot(self._along[:, 0], self._along[:, 1])
        self._on = np.ones(len(segments), dtype=np.bool_)
        self._reach = reach
        self._culled_at: tuple[float, float] | None = None
        self._near: NDArray[np.intp] = np.arange(len(segments))

    def switch(self, index: int, *, on: bool) -> None:
        """Put a segment into the way of rays, or take it out."""
        self._on[index] = on
        self._culled_at = None

    def cast(self, origins: Floats, angles: Floats) -> tuple[Floats, Floats]:
        """Cast rays that start near each other.

        Args:
            origins: shape (k, 2), metres.
            angles: shape (k,), radians in the frame of the segments.

        Returns:
            Distances, shape (k,), ``inf`` beyond the reach, and the cosines of the angles of
            incidence, shape (k,): 1 for a wall met head-on.
        """
        near = self._cull(float(origins[0, 0]), float(origins[0, 1]))
        if near.size == 0:
            return np.full(len(angles), np.inf), np.ones(len(angles))
        distance, cosine = self._meet(near, origins, angles)
        nearest = distance.argmin(axis=1)
        rows = np.arange(len(angles))
        hit = distance[rows, nearest]
        hit[hit > self._reach] = np.inf
        return hit, cosine[rows, nearest]

    def _meet(
        self, near: NDArray[np.intp], origins: Floats, angles: Floats
    ) -> tuple[Floats, Floats]:
        """All rays against the segments ``near``: distances and cosines, shape (k, len(near))."""
        ux, uy = np.cos(angles)[:, None], np.sin(angles)[:, None]
        along, start = self._along[near], self._start[near]
        dx, dy = along[:, 0], along[:, 1]
        wx, wy = start[:, 0] - origins[:, :1], start[:, 1] - origins[:, 1:]
        cross = ux * dy - uy * dx
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            distance = (wx * dy - wy * dx) / cross
            share = (wx * uy - wy * ux) / cross
        met = (distance >= 0.0) & (share >= -END_TOLERANCE) & (share <= 1.0 + END_TOLERANCE)
        return np.where(met, distance, np.inf), np.abs(cross) / self._length[near]

    def _cull(self, x: float, y: float) -> NDArray[np.intp]:
        """The switched-on segments that a ray from near (x, y) can reach."""
        at = self._culled_at
        if at is None or abs(at[0] - x) + abs(at[1] - y) > CULL_MARGIN / 2:
            self._culled_at = (x, y)
            reach = self._reach + CULL_MARGIN
            self._near = np.flatnonzero(self._on & (self.distances(x, y) <= reach))
        return self._near

    def distances(self, x: float, y: float) -> Floats:
        """The distance from a point to each segment, shape (n,), whether switched on or off."""
        to_x, to_y = x - self._start[:, 0], y - self._start[:, 1]
        dx, dy = self._along[:, 0], self._along[:, 1]
        share = np.clip((to_x * dx + to_y * dy) / self._length**2, 0.0, 1.0)
        distance: Floats = np.hypot(to_x - share * dx, to_y - share * dy)
        return distance
