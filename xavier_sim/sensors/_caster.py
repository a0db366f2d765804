"""What every ray caster knows: the segments of a floor, which of them are there, and circles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

END_TOLERANCE = 1e-9
"""Share of a segment's length that is added at both ends, so that corners have no gap."""

PARALLEL = 1e-7
"""A ray that meets a segment at a smaller angle, in radians, passes along it."""

NO_CIRCLES: Floats = np.empty((0, 3))


class Bundle(NamedTuple):
    """Rays: where they start, shape (k, 2), metres, and where they look, shape (k,), radians."""

    origins: Floats
    angles: Floats


class Caster(ABC):
    """Casts rays at the segments of a floor, some of which (doors) can be switched off.

    All casters give the same distances and cosines, bit for bit.

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

    def switch(self, index: int, *, on: bool) -> None:
        """Put a segment into the way of rays, or take it out."""
        self._on[index] = on

    def cast(
        self, origins: Floats, angles: Floats, *, circles: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Cast rays that start within a metre of the first one's start.

        Args:
            origins: shape (k, 2), metres.
            angles: shape (k,), radians in the frame of the segments.
            circles: shape (m, 3), x, y and radius in metres of what stands about; a ray that
                starts in one meets it at once.

        Returns:
            Distances, shape (k,), ``inf`` beyond the reach, and the cosines of the angles of
            incidence, shape (k,): 1 for what is met head-on, and where nothing is met.
        """
        directions = np.cos(angles), np.sin(angles)
        return self._cast(origins, *directions, NO_CIRCLES if circles is None else circles)

    def distances(self, x: float, y: float) -> Floats:
        """The distance from a point to each segment, shape (n,), whether switched on or off."""
        to_x, to_y = x - self._start[:, 0], y - self._start[:, 1]
        dx, dy = self._along[:, 0], self._along[:, 1]
        share = np.clip((to_x * dx + to_y * dy) / self._length**2, 0.0, 1.0)
        distance: Floats = np.hypot(to_x - share * dx, to_y - share * dy)
        return distance

    @abstractmethod
    def _cast(
        self, origins: Floats, ux: Floats, uy: Floats, circles: Floats
    ) -> tuple[Floats, Floats]:
        """Cast along unit vectors, each of shape (k,)."""
