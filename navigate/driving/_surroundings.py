"""Echoes around the robot: the last of each sonar, and near ones for a little longer.

Kept in the odometry frame, so that an echo stays where it was heard while the robot moves on. One
that is kept goes early when sonars hear nothing there any more: what stood there has walked on.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from navigate.body import BEARINGS, CONE_HALF, PITCH, RING_RADIUS, Pose, fresh_sonars
from navigate.maps import Floats
from xavier_sim.messages import SONAR_COUNT

NEAR = 0.9
"""Metres below which an echo is sharp enough to be kept after the sonar has moved on."""

KEPT_SECONDS = 5.0
MOST_KEPT = 80

BEYOND = 0.3
"""Metres by which a sonar must hear farther than an echo that is not there any more."""

MISSES = 2
"""Readings past an echo that it takes to forget it: one may have glanced off."""

ALIKE = 0.2
"""Metres between the readings of two neighbours that hear the same thing."""

_TIME, _X, _Y, _MISSED = range(4)


class Surroundings:
    """What the sonars have heard lately."""

    STATE: ClassVar[tuple[str, ...]] = ("_last", "_kept", "_next")

    def __init__(self) -> None:
        self._last: Floats = np.full((SONAR_COUNT, 2), np.inf)
        self._kept: Floats = np.full((MOST_KEPT, 4), np.inf)
        self._next = 0

    def hear(self, odom: Pose, ranges: Floats, fresh: int, time: float) -> None:
        """Take in the fresh ones of 24 ``ranges`` (metres from the ring)."""
        sonars = np.array(fresh_sonars(fresh), dtype=np.intp)
        age = time - self._kept[:, _TIME]
        self._kept[(age < 0.0) | (age >= KEPT_SECONDS)] = np.inf
        self._forget_past(odom, ranges, sonars)
        spots = _spots(odom, BEARINGS[sonars] + lean(ranges, sonars), ranges[sonars])
        self._last[sonars] = spots
        self._keep(spots[ranges[sonars] < NEAR], time)

    def touch(self, odom: Pose, direction: float, time: float) -> None:
        """Remember a contact as if it had been heard: the sonars may not see it."""
        self._keep(_spots(odom, np.array([direction]), np.array([0.1])), time)

    def around(self, odom: Pose, *, within: float) -> Floats:
        """Echoes within some metres, in the robot's frame: ahead and left, shape (n, 2)."""
        spots = np.concatenate([self._last, self._kept[:, _X : _Y + 1]]) - odom[:2]
        spots = spots[(spots**2).sum(axis=1) < within**2]
        cos, sin = math.cos(odom[2]), math.sin(odom[2])
        return np.asarray(spots @ np.array([[cos, -sin], [sin, cos]]))

    def _keep(self, spots: Floats, time: float) -> None:
        for spot in spots:
            self._kept[self._next] = (time, spot[0], spot[1], 0.0)
            self._next = (self._next + 1) % MOST_KEPT

    def _forget_past(self, odom: Pose, ranges: Floats, sonars: NDArray[np.intp]) -> None:
        """Count the kept echoes that fresh readings went past, and forget those missed often."""
        held = np.flatnonzero(np.isfinite(self._kept[:, _TIME]))
        if len(held) == 0 or len(sonars) == 0:
            return
        dx, dy = self._kept[held, _X] - odom[0], self._kept[held, _Y] - odom[1]
        past = np.hypot(dx, dy)[:, None] < RING_RADIUS + ranges[sonars] - BEYOND
        off = np.arctan2(dy, dx)[:, None] - odom[2] - BEARINGS[sonars]
        past &= np.cos(off) > _WELL_WITHIN
        missed = self._kept[held, _MISSED] + past.any(axis=1)
        self._kept[held, _MISSED] = missed
        self._kept[held[missed >= MISSES]] = np.inf


def lean(ranges: Floats, sonars: NDArray[np.intp]) -> Floats:
    """Radians to the left of its axis at which a sonar's echo likely is, shape of ``sonars``.

    What is heard by one of its neighbours as well is between the two.
    """
    own = np.where(np.isfinite(ranges[sonars]), ranges[sonars], -np.inf)
    left = np.abs(ranges[(sonars + 1) % SONAR_COUNT] - own) < ALIKE
    right = np.abs(ranges[sonars - 1] - own) < ALIKE
    return np.asarray(0.5 * PITCH * (left.astype(np.float64) - right))


_WELL_WITHIN = math.cos(0.7 * CONE_HALF)


def _spots(odom: Pose, bearings: Floats, ranges: Floats) -> Floats:
    """Where readings lie, shape (n, 2); infinite where nothing was heard."""
    spots = np.full((len(ranges), 2), np.inf)
    heard = np.isfinite(ranges)
    distance, angle = RING_RADIUS + ranges[heard], odom[2] + bearings[heard]
    spots[heard, 0] = odom[0] + distance * np.cos(angle)
    spots[heard, 1] = odom[1] + distance * np.sin(angle)
    return spots
