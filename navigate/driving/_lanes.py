"""Choosing a lane: parallels to the way, judged by how far they are free.

After Ko & Simmons, The Lane-Curvature Method for Local Obstacle Avoidance, IROS 1998: a lane is
picked first, then the curvature-velocity method drives along it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navigate.body import ROBOT_RADIUS
from navigate.maps import Floats

SPACING = 0.1
"""Metres from lane to lane."""

BERTH = ROBOT_RADIUS + 0.07
"""Metres from the middle of a lane that must be free."""

FAR_ENOUGH = 2.2
"""Metres of free lane beyond which more is no better."""

CHANGE_COST = 0.35
"""Metres of free lane that a change of lane by one metre must win."""

OFF_COST = 0.5
"""The same for driving a metre beside the way."""

TURN_BACK_COST = 0.5
"""The same for a metre off the lane that was chosen before, while something is ahead."""


@dataclass(frozen=True, slots=True)
class Lane:
    """A parallel to the way: metres to its left, and metres free ahead in it.

    ``straight`` are the metres that are free ahead of the robot, which is not in it yet.
    """

    offset: float
    free: float
    straight: float = math.inf


def pick_lane(
    echoes: Floats, here: float, lowest: float, highest: float, chosen: float | None = None
) -> Lane:
    """Pick the lane that is best to go on in.

    Args:
        echoes: metres ahead along the way and metres to its left, shape (n, 2).
        here: where the robot is, metres to the left of the way.
        lowest: the rightmost offset that the floor leaves room for.
        highest: the leftmost.
        chosen: the offset that was picked before, if any.
    """
    first = round(min(lowest, 0.0) / SPACING)
    last = round(max(highest, 0.0) / SPACING)
    offsets = SPACING * np.arange(first, last + 1, dtype=np.float64)
    free = free_ahead(echoes, offsets)
    score = np.minimum(free, FAR_ENOUGH)
    score = score - CHANGE_COST * np.abs(offsets - here) - OFF_COST * np.abs(offsets)
    straight = float(free[np.abs(offsets - here).argmin()])
    if chosen is not None and straight < FAR_ENOUGH:
        score = score - TURN_BACK_COST * np.abs(offsets - chosen)
    best = int(score.argmax())
    return Lane(float(offsets[best]), float(free[best]), straight)


def free_ahead(echoes: Floats, offsets: Floats) -> Floats:
    """Metres that a robot can drive along lanes at ``offsets`` (m,) before it meets an echo."""
    ahead, left = echoes[:, 0], echoes[:, 1]
    meets = (np.abs(left - offsets[:, None]) < BERTH) & (ahead > 0.1)
    reach = np.where(meets, ahead - ROBOT_RADIUS, np.inf)
    return np.asarray(reach.min(axis=1, initial=np.inf))
