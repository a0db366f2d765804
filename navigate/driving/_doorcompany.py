"""Who stands in the way to a door, or out of it: before its jambs or behind them."""

from __future__ import annotations

import numpy as np

from navigate.body import BEARINGS, RING_RADIUS, ROBOT_RADIUS
from navigate.maps import Floats

OFF_LINE = 0.25
"""Metres before and behind the line of a door within which an echo may be of its jambs."""

BERTH = ROBOT_RADIUS + 0.1
"""Metres beside the robot's way through a door within which somebody is in it."""

ROOM = ROBOT_RADIUS + 0.35
"""Metres ahead of the robot's centre at which it has to stand."""

NEAR_BY = ROBOT_RADIUS + 0.75
"""Metres from the robot's centre within which somebody who walks may be there at any moment."""

FEWEST = 2
"""Sonars that must hear it: one alone may hear a ghost."""


def is_near(robot: tuple[float, float, float], ranges: Floats) -> bool:
    """Whether somebody may step or walk into a robot that passes a door, from ahead or aside.

    One sonar that hears them is enough: it costs no more than to creep.

    Args:
        robot: metres beyond the line of the door and to its left, radians turned to the left.
        ranges: metres from the ring, shape (24,).
    """
    heard = ranges[_BEFORE]
    away = RING_RADIUS + np.where(np.isfinite(heard), heard, 100.0)
    off_line = np.abs(robot[0] + away * np.cos(robot[2] + _BEFORE_LOOKS)) > OFF_LINE
    return bool((off_line & (away < NEAR_BY)).any())


_BEFORE = np.flatnonzero(np.cos(BEARINGS) > 0.1)
_BEFORE_LOOKS: Floats = BEARINGS[_BEFORE]
_AHEAD = np.flatnonzero(np.cos(BEARINGS) > 0.45)
_LOOKS: Floats = BEARINGS[_AHEAD]


def stands_in_way(robot: tuple[float, float, float], ranges: Floats) -> bool:
    """Whether somebody stands right before a robot that passes a door, as its sonars hear.

    Args:
        robot: metres beyond the line of the door and to its left, radians turned to the left.
        ranges: metres from the ring, shape (24,).
    """
    heard = ranges[_AHEAD]
    away = RING_RADIUS + np.where(np.isfinite(heard), heard, 100.0)
    looks = robot[2] + _LOOKS
    along, left = away * np.cos(looks), robot[1] + away * np.sin(looks)
    near = (along > 0.0) & (along < ROOM) & (np.abs(left) < BERTH)
    return int((near & (np.abs(robot[0] + along) > OFF_LINE)).sum()) >= FEWEST
