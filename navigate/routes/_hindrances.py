"""What is believed to be in the way of a route, for certain or with some probability."""

from __future__ import annotations

import math
from dataclasses import dataclass

from navigate.maps import Point
from navigate.routes._graph import Link

BLOCKED_BERTH = 0.9
"""Metres to keep a route from a point where something stood in the way."""


@dataclass(frozen=True, slots=True)
class Hindrances:
    """Doors that are closed and points that are occupied, and others that may be.

    ``doors`` and ``points`` block. ``doubtful_doors`` and ``doubtful_points`` come with the
    seconds that going there costs on the average, since they may be blocked still.
    """

    doors: frozenset[str] = frozenset()
    points: tuple[Point, ...] = ()
    doubtful_doors: tuple[tuple[str, float], ...] = ()
    doubtful_points: tuple[tuple[Point, float], ...] = ()

    def __bool__(self) -> bool:
        """Whether there is anything in the way, or may be."""
        return bool(self.doors or self.points or self.doubtful_doors or self.doubtful_points)

    def stops(self, link: Link, one: Point, other: Point) -> bool:
        """Whether the link between two points is believed to be blocked."""
        return link.door in self.doors or bool(self.points and self.lie_between(one, other))

    def lie_between(self, one: Point, other: Point) -> bool:
        """Whether an occupied point lies on the straight way between two points."""
        return any(_off_segment(point, one, other) < BLOCKED_BERTH for point in self.points)

    def lie_ahead(self, start: Point, other: Point) -> bool:
        """The same for a robot at ``start``, which may be near such a point if it leaves it."""
        return any(_ahead(point, start, other) for point in self.points)

    def delay(self, door: str | None, one: Point, other: Point) -> float:
        """Seconds that doubt about a straight way costs on the average, through ``door`` if any."""
        seconds = 0.0
        if door is not None:
            seconds += sum(lost for name, lost in self.doubtful_doors if name == door)
        for point, lost in self.doubtful_points:
            if _off_segment(point, one, other) < BLOCKED_BERTH:
                seconds += lost
        return seconds


def _ahead(point: Point, start: Point, other: Point) -> bool:
    return _off_segment(point, start, other) < min(BLOCKED_BERTH, math.dist(point, start) - 0.05)


def _off_segment(point: Point, one: Point, other: Point) -> float:
    """Metres from a point to a straight way."""
    dx, dy = other[0] - one[0], other[1] - one[1]
    square = dx * dx + dy * dy
    part = ((point[0] - one[0]) * dx + (point[1] - one[1]) * dy) / square if square else 0.0
    part = min(1.0, max(0.0, part))
    return math.dist(point, (one[0] + part * dx, one[1] + part * dy))
