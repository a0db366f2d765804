"""What a laser sees of a door: the wall beside it, and where that ends.

A beam that meets the line of the wall sees it; one that should and does not goes through the
opening. Where one kind follows the other is a jamb.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigate.body import Laser
from navigate.maps import Floats

OFF_WALL = 0.15
"""Metres from the line of the wall within which a beam has met it."""

BEYOND = 0.3
"""Metres behind the line that a beam sees, or nothing at all, when it goes through."""

LEAST_AHEAD = 0.1
"""Metres that the laser must stand before the line."""

SHORT_OF_FARTHEST = 0.5
"""Metres before the end of its sight within which a beam would see the wall if it was there."""

BESIDE, LEAST_COSINE = 0.9, 0.4
"""Metres from the middle, and cosine of the angle, up to which a beam is taken to meet this wall.

Farther off, or grazing, it may meet the next one, which looks much the same then.
"""

EVERY = 5
"""One point of the wall in so many is told: neighbours tell the same."""

Flags = NDArray[np.bool_]


class DoorSight(NamedTuple):
    """What is seen of a door, in its frame: metres beyond its line and to the left.

    ``wall`` are points of it, shape (n, 2); ``right_jambs`` and ``left_jambs`` tell where the
    wall ends, metres to the left of the middle.
    """

    wall: Floats
    right_jambs: list[float]
    left_jambs: list[float]


def look_at_door(robot: tuple[float, float, float], laser: Laser, ranges: Floats) -> DoorSight:
    """What the ``ranges`` (beams,) of a laser tell of the door that a robot stands before.

    Args:
        robot: metres beyond the line of the door and to its left, radians turned to the left.
        laser: whose they are.
        ranges: metres, inf where nothing was seen.
    """
    looks = robot[2] + laser.bearings
    cos, sin = np.cos(looks), np.sin(looks)
    ahead = robot[0] + laser.ahead * math.cos(robot[2])
    left = robot[1] + laser.ahead * math.sin(robot[2])
    if ahead > -LEAST_AHEAD:
        return DoorSight(np.zeros((0, 2)), [], [])
    expected = np.where(cos > 0.0, -ahead / np.maximum(cos, 1e-3), 1e3)
    crossing = left + expected * sin
    should = (
        (expected < laser.farthest - SHORT_OF_FARTHEST)
        & (cos > LEAST_COSINE)
        & (np.abs(crossing) < BESIDE)
    )
    meets = should & (np.abs(ranges - expected) * cos < OFF_WALL)
    passes = should & (ranges > expected + BEYOND)
    wall = np.flatnonzero(meets)[::EVERY]
    seen = ranges[wall]
    points = np.column_stack([ahead + seen * cos[wall], left + seen * sin[wall]])
    right = _ends(meets, passes, crossing)
    return DoorSight(points, right, _ends(meets[::-1], passes[::-1], crossing[::-1]))


def _ends(meets: Flags, passes: Flags, crossing: Floats) -> list[float]:
    """Where two beams that meet the wall are followed by two that pass it."""
    turns = meets[:-3] & meets[1:-2] & passes[2:-1] & passes[3:]
    return [float(crossing[i + 1] + crossing[i + 2]) / 2.0 for i in np.flatnonzero(turns)]
