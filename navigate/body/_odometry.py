"""Motion between two odometry readings, and how much a filter should doubt it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from navigate.body._sonarring import wrap

Pose = tuple[float, float, float]
"""x, y in metres and theta in radians."""

JUMP = 0.35
"""Metres in a tick beyond which odometry did not move but was set anew."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Metres ahead and to the left in the robot's frame, and radians turned."""

    ahead: float
    aside: float
    turn: float

    @property
    def metres(self) -> float:
        """The distance covered."""
        return math.hypot(self.ahead, self.aside)

    def still(self) -> bool:
        """Whether the robot practically stood."""
        return self.metres < 1e-4 and abs(self.turn) < 1e-4


def motion_between(before: Pose, now: Pose) -> Motion:
    """The motion from one odometry pose to another."""
    dx, dy, turn = now[0] - before[0], now[1] - before[1], wrap(now[2] - before[2])
    heading = before[2] + turn / 2
    cos, sin = math.cos(heading), math.sin(heading)
    return Motion(dx * cos + dy * sin, dy * cos - dx * sin, turn)


def plausible(motion: Motion, seconds: float) -> bool:
    """Whether a robot can have moved so in ``seconds``; if not, its odometry was reset."""
    return motion.metres < JUMP + 1.0 * max(0.0, seconds)


def moved(pose: Pose, motion: Motion) -> Pose:
    """The pose after a motion."""
    heading = pose[2] + motion.turn / 2
    cos, sin = math.cos(heading), math.sin(heading)
    return (
        pose[0] + motion.ahead * cos - motion.aside * sin,
        pose[1] + motion.ahead * sin + motion.aside * cos,
        wrap(pose[2] + motion.turn),
    )
