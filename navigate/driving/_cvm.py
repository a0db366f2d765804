"""The curvature-velocity method: choose speed and turn rate among arcs between obstacles.

The objective is linear in speed and in heading error on every interval of curvature with one
free distance, so its best value in the dynamic window lies at a corner of the window, of the
interval, or where one of them crosses the turn rate that is wanted. After Simmons, The
Curvature-Velocity Method for Local Obstacle Avoidance, ICRA 1996, section 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from navigate.body import ROBOT_RADIUS
from navigate.driving._arcs import Spans, free_spans
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

TOP_SPEED = 0.65
"""Metres per second."""

TOP_TURN = 0.9
"""Radians per second while driving."""

WINDOW_SECONDS = 0.2
"""Two ticks: what is wanted now is judged anew before it is reached."""

ACCELERATION, SLOWING, TURN_ACCELERATION = 0.7, 1.4, 3.0
"""What the base can do in a second: metres per second, and radians per second."""


class Window(NamedTuple):
    """The dynamic window: speeds in m/s and turn rates in rad/s that can be had soon."""

    slowest: float
    fastest: float
    right: float
    left: float

    @classmethod
    def whole(cls, top_speed: float) -> Window:
        """All speeds up to one, as if the base had no mass."""
        return cls(0.0, top_speed, -TOP_TURN, TOP_TURN)

    @classmethod
    def around(cls, speed: float, turn: float, top_speed: float) -> Window:
        """What a base that moves at ``speed`` and ``turn`` can reach within `WINDOW_SECONDS`."""
        slowest = max(0.0, speed - SLOWING * WINDOW_SECONDS)
        fastest = max(slowest, min(top_speed, speed + ACCELERATION * WINDOW_SECONDS))
        reach = TURN_ACCELERATION * WINDOW_SECONDS
        turn = min(TOP_TURN, max(-TOP_TURN, turn))
        return cls(slowest, fastest, max(-TOP_TURN, turn - reach), min(TOP_TURN, turn + reach))


@dataclass(frozen=True, slots=True)
class Choice:
    """Wheels that were chosen, and the free metres along their arc."""

    wheels: Wheels
    free: float


def choose(echoes: Floats, heading: float, window: Window, *, margin: float = MARGIN) -> Choice:
    """Choose wheels for a robot among ``echoes`` (n, 2) that wants to turn by ``heading``.

    Returns:
        The best admissible choice; `STOP` with the free metres ahead when there is none.
    """
    x, y = echoes[:, 0], echoes[:, 1]
    spans = free_spans(x, y, ROBOT_RADIUS + margin, within=HORIZON)
    top = np.sqrt(2.0 * BRAKING * np.maximum(spans.free - HALT, 0.0))
    admissible = (top > 0.0) & (top >= window.slowest)
    top = np.minimum(top, window.fastest)
    wanted = min(window.left, max(window.right, heading / LOOK_AHEAD))
    speeds = _corner_speeds(spans, window, wanted, top)
    right = np.maximum(spans.low * speeds, window.right)
    left = np.minimum(spans.high * speeds, window.left)
    turns = np.minimum(np.maximum(wanted, right), left)
    score = _score(speeds, turns, spans.free, heading)
    np.copyto(score, -np.inf, where=~(admissible & (right <= left + 1e-9)))
    row, column = divmod(int(score.argmax()), len(top))
    if not math.isfinite(score[row, column]) or speeds[row, column] <= 0.0:
        return Choice(STOP, spans.at(0.0))
    wheels = Wheels(float(speeds[row, column]), float(turns[row, column]))
    return Choice(wheels, float(spans.free[column]))


def _corner_speeds(spans: Spans, window: Window, wanted: float, top: Floats) -> Floats:
    """Speeds at which the objective may have its best value, shape (8, m)."""
    turns = np.array([window.right, window.left, wanted])[:, None]
    speeds = np.empty((8, len(top)))
    speeds[0], speeds[1] = window.slowest, top
    with np.errstate(divide="ignore", invalid="ignore"):
        np.divide(turns, spans.low, out=speeds[2:5])
        np.divide(turns, spans.high, out=speeds[5:8])
    np.copyto(speeds, window.slowest, where=np.isnan(speeds))
    return np.minimum(np.maximum(speeds, window.slowest), top)


def _score(speeds: Floats, turns: Floats, free: Floats, heading: float) -> Floats:
    off = np.abs(heading - turns * LOOK_AHEAD)
    score = (SPEED_WEIGHT / TOP_SPEED) * speeds - (HEADING_WEIGHT / math.pi) * off
    return np.asarray(score + (FREE_WEIGHT / HORIZON) * np.minimum(free, HORIZON))
