"""Echoes around the robot: the last of each sonar, and near ones for a little longer.

Kept in the odometry frame, so that an echo stays where it was heard while the robot moves on.
"""

from __future__ import annotations

import math
from collections import deque
from typing import ClassVar, NamedTuple

import numpy as np

from navigate.body import BEARINGS, RING_RADIUS, Pose, fresh_sonars
from navigate.maps import Floats
from xavier_sim.messages import SONAR_COUNT

NEAR = 0.9
"""Metres below which an echo is sharp enough to be kept after the sonar has moved on."""

KEPT_SECONDS = 5.0
MOST_KEPT = 80


class _Echo(NamedTuple):
    time: float
    x: float
    y: float


class Surroundings:
    """What the sonars have heard lately."""

    STATE: ClassVar[tuple[str, ...]] = ("_last", "_heard")

    def __init__(self) -> None:
        self._last: Floats = np.full((SONAR_COUNT, 2), np.inf)
        self._kept: deque[_Echo] = deque(maxlen=MOST_KEPT)

    def hear(self, odom: Pose, ranges: Floats, fresh: int, time: float) -> None:
        """Take in the fresh ones of 24 ``ranges`` (metres from the ring)."""
        while self._kept and not 0.0 <= time - self._kept[0].time < KEPT_SECONDS:
            self._kept.popleft()
        for number in fresh_sonars(fresh):
            spot = _spot(odom, float(BEARINGS[number]), float(ranges[number]))
            self._last[number] = spot
            if ranges[number] < NEAR:
                self._kept.append(_Echo(time, *spot))

    @property
    def _heard(self) -> list[tuple[float, float, float]]:
        return [(echo.time, echo.x, echo.y) for echo in self._kept]

    @_heard.setter
    def _heard(self, echoes: list[tuple[float, float, float]]) -> None:
        self._kept = deque((_Echo(*echo) for echo in echoes), maxlen=MOST_KEPT)

    def touch(self, odom: Pose, direction: float, time: float) -> None:
        """Remember a contact as if it had been heard: the sonars may not see it."""
        self._kept.append(_Echo(time, *_spot(odom, direction, 0.1)))

    def around(self, odom: Pose, *, within: float) -> Floats:
        """Echoes within some metres, in the robot's frame: ahead and left, shape (n, 2)."""
        kept = np.array([echo[1:] for echo in self._kept]).reshape(-1, 2)
        spots = np.concatenate([self._last, kept])
        spots = spots[np.isfinite(spots[:, 0])] - odom[:2]
        spots = spots[(spots**2).sum(axis=1) < within**2]
        cos, sin = math.cos(odom[2]), math.sin(odom[2])
        return np.asarray(spots @ np.array([[cos, -sin], [sin, cos]]))


def _spot(odom: Pose, bearing: float, reading: float) -> tuple[float, float]:
    if not math.isfinite(reading):
        return (math.inf, math.inf)
    distance, angle = RING_RADIUS + reading, odom[2] + bearing
    return (odom[0] + distance * math.cos(angle), odom[1] + distance * math.sin(angle))
