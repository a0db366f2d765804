"""Motion reports: odometry as turns of a quarter and ways of a metre along the walls.

Walls stand at right angles, so directions are told by the quarters of an *axis*, the angle of the
walls in dead reckoning; that angle drifts, and is told anew now and then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from navigate.body._localgrid import LocalGrid
from navigate.body._odometry import Motion, Pose, moved
from navigate.body._sonarring import wrap
from navigate.maps import Floats, Point

QUARTER = math.pi / 2

METRE = 1.0
"""Metres of a motion that is reported."""

BEYOND = math.radians(55.0)
"""How far the robot must look away from a direction to count as turned."""

_CANDIDATES: Floats = np.radians(np.arange(0.0, 90.0, 2.5))
_FEWEST = 12
_BIN = 0.1


@dataclass(frozen=True, slots=True)
class Moved:
    """The robot moved about a metre, ``relative`` quarters to the left of where it looks."""

    relative: int


@dataclass(frozen=True, slots=True)
class Turned:
    """The robot turned to the left by so many quarters."""

    quarters: int


class MotionReports:
    """Adds up motions and reports them when they amount to something."""

    STATE: ClassVar[tuple[str, ...]] = ("pose", "axis", "_heading", "_mark")

    def __init__(self) -> None:
        self.begin(0.0)

    def begin(self, theta: float) -> None:
        """Begin anew in a robot that looks ``theta`` radians to the left of the walls' axis."""
        self.pose: Pose = (0.0, 0.0, theta)
        self.axis = 0.0
        self._heading = round(theta / QUARTER) % 4
        self._mark: Point = (0.0, 0.0)

    def align(self, axis: float) -> None:
        """Take the walls to stand at ``axis`` radians, in dead reckoning, or a quarter from it."""
        self.axis += wrap(4.0 * (axis - self.axis)) / 4.0

    @property
    def facing(self) -> Pose:
        """The robot as if it looked exactly along the walls."""
        return (self.pose[0], self.pose[1], self.axis + self._heading * QUARTER)

    @property
    def turned(self) -> float:
        """Radians by which the robot looks to the left of the direction reported."""
        return wrap(self.pose[2] - self.axis - self._heading * QUARTER)

    def move(self, motion: Motion) -> list[Moved | Turned]:
        """Take in a motion; what there is to report then."""
        self.pose = moved(self.pose, motion)
        reports: list[Moved | Turned] = []
        if (way := self._way()) is not None:
            reports.append(way)
        if abs(self.turned) > BEYOND:
            quarters = 1 if self.turned > 0.0 else -1
            self._heading = (self._heading + quarters) % 4
            reports.append(Turned(quarters))
        return reports

    def _way(self) -> Moved | None:
        dx, dy = self.pose[0] - self._mark[0], self.pose[1] - self._mark[1]
        cos, sin = math.cos(self.axis), math.sin(self.axis)
        along, across = dx * cos + dy * sin, dy * cos - dx * sin
        if max(abs(along), abs(across)) < METRE:
            return None
        if abs(along) >= abs(across):
            direction, step = (0 if along > 0.0 else 2), (math.copysign(METRE, along), 0.0)
        else:
            direction, step = (1 if across > 0.0 else 3), (0.0, math.copysign(METRE, across))
        self._mark = (
            self._mark[0] + step[0] * cos - step[1] * sin,
            self._mark[1] + step[0] * sin + step[1] * cos,
        )
        return Moved((direction - self._heading) % 4)


def find_axis(grid: LocalGrid) -> float | None:
    """The angle of the walls around, radians in [0, pi / 2); None when too little is known.

    That along which, and across which, most of what was heard lines up.
    """
    points = grid.occupied()
    if len(points) < _FEWEST:
        return None
    cos, sin = np.cos(_CANDIDATES)[:, None], np.sin(_CANDIDATES)[:, None]
    x, y = points[:, 0], points[:, 1]
    scores = _peaks(x * cos + y * sin) + _peaks(y * cos - x * sin)
    return float(_CANDIDATES[int(scores.argmax())])


def _peaks(values: Floats) -> Floats:
    """How strongly the values (n, m) of each row come together: sums of squared counts."""
    bins = np.floor(values / _BIN).astype(np.int64)
    bins -= bins.min()
    width = int(bins.max()) + 1
    rows = np.arange(len(bins))[:, None] * width
    counts = np.bincount((rows + bins).ravel(), minlength=width * len(bins))
    return np.asarray((counts.reshape(len(bins), width).astype(np.float64) ** 2).sum(axis=1))
