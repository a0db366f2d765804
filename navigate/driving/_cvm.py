"""The curvature-velocity method: choose speed and turn rate among arcs between obstacles.

Frame: x ahead, y to the left, curvature c = turn rate / speed, positive to the left. An obstacle
circle (x, y) of radius r, inflated by the robot, blocks exactly the curvatures between
2 (y - r) / (x^2 + y^2 - r^2) and 2 (y + r) / (x^2 + y^2 - r^2).
After Simmons, The Curvature-Velocity Method for Local Obstacle Avoidance, ICRA 1996, section 3,
with these bounds derived anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navigate.body import ROBOT_RADIUS
from navigate.driving._view import STOP, Wheels
from navigate.maps import Floats

MARGIN = 0.09
"""Metres that the robot keeps off echoes while it passes them."""

HORIZON = 2.5
"""Metres of free arc beyond which more is no better."""

BRAKING = 0.5
"""Metres per second squared that the method counts on to stop."""

HALT = 0.12
"""Metres of free arc that must remain when the robot has stopped."""

SPEED_WEIGHT, FREE_WEIGHT, HEADING_WEIGHT = 0.3, 0.8, 1.0
LOOK_AHEAD = 0.9
"""Seconds over which a turn rate changes the heading that is judged."""

_TURNS: Floats = 0.075 * np.arange(-12, 13, dtype=np.float64)
_SHARES: Floats = np.linspace(0.2, 1.0, 6)


@dataclass(frozen=True, slots=True)
class Choice:
    """Wheels that were chosen, and the free metres along their arc."""

    wheels: Wheels
    free: float


def blocked_curvatures(x: Floats, y: Floats, radius: float) -> tuple[Floats, Floats]:
    """Bounds of the curvatures that circles block; infinite where the robot is inside of one.

    Args:
        x: metres ahead of the robot, shape (n,).
        y: metres to the left, shape (n,).
        radius: metres, inflated by the robot's own.
    """
    power = x * x + y * y - radius * radius
    inside = power <= 1e-9
    safe = np.where(inside, 1.0, power)
    low = np.where(inside, -np.inf, 2.0 * (y - radius) / safe)
    high = np.where(inside, np.inf, 2.0 * (y + radius) / safe)
    return low, high


def free_arcs(curvatures: Floats, x: Floats, y: Floats, radius: float) -> Floats:
    """Metres along arcs of ``curvatures`` (m,) until they enter one of n circles; inf if never.

    Circles that hold the robot already block only ways that lead further in: those ahead.
    """
    if len(x) == 0:
        return np.full(len(curvatures), np.inf)
    low, high = blocked_curvatures(x, y, radius)
    bent = curvatures[:, None]
    blocks = (bent > low) & (bent < high)
    reach = np.where(blocks, _entry(bent, x, y, radius), np.inf)
    return np.asarray(reach.min(axis=1))


def choose(echoes: Floats, heading: float, *, top_speed: float, margin: float = MARGIN) -> Choice:
    """Choose wheels for a robot among ``echoes`` (n, 2) that wants to turn by ``heading``.

    Returns:
        The best admissible choice; `STOP` with the free metres ahead when there is none.
    """
    x, y = echoes[:, 0], echoes[:, 1]
    speeds = (_SHARES * top_speed)[:, None]
    curvatures = _TURNS / speeds
    free = free_arcs(curvatures.ravel(), x, y, ROBOT_RADIUS + margin).reshape(curvatures.shape)
    admissible = speeds**2 <= 2.0 * BRAKING * (free - HALT).clip(min=0.0)
    if not admissible.any():
        return Choice(STOP, float(free[:, len(_TURNS) // 2].min()))
    off = np.abs((heading - _TURNS * LOOK_AHEAD + math.pi) % (2.0 * math.pi) - math.pi)
    score = SPEED_WEIGHT * speeds / top_speed - HEADING_WEIGHT * off / math.pi
    score = score + FREE_WEIGHT * np.minimum(free, HORIZON) / HORIZON
    best = np.where(admissible, score, -np.inf).argmax()
    row, column = divmod(int(best), len(_TURNS))
    wheels = Wheels(float(speeds[row, 0]), float(_TURNS[column]))
    return Choice(wheels, float(free[row, column]))


def _entry(curvature: Floats, x: Floats, y: Floats, radius: float) -> Floats:
    """Arc length at which the arc enters each circle that it meets, shape (m, n)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        straight = x - np.sqrt(np.maximum(radius**2 - y**2, 0.0))
        turning = 1.0 / curvature
        away = np.hypot(x, y - turning)
        span = (turning**2 + away**2 - radius**2) / (2.0 * np.abs(turning) * away)
        half = np.arccos(np.clip(span, -1.0, 1.0))
        side = np.sign(turning)
        toward = np.arctan2(x, side * (turning - y)) % (2.0 * math.pi)
        bent = ((toward - half) % (2.0 * math.pi)) * np.abs(turning)
    reach = np.where(np.abs(curvature) < 1e-6, np.where(straight < 0, np.inf, straight), bent)
    inside = x * x + y * y <= radius * radius
    return np.where(inside, np.where(x > 0.5 * radius, 0.0, np.inf), reach)
