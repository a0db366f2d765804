"""Following a straight way through open floor: curvature-velocity, waiting, going round."""

from __future__ import annotations

import math

from navigate.cvm import choose, widest_turn
from navigate.graph import Point
from navigate.turning import turn_by, turn_rate
from navigate.view import STOP, Manoeuvre, View, WayBlocked, Wheels, heading_to

TOP_SPEED = 0.6
SLOW_SPEED = 0.12
CARROT = 1.1
"""Metres ahead on the line that the robot steers for."""

ECHO_RANGE = 3.0
TURN_FIRST = 0.7
"""Radians off beyond which the robot turns on the spot before it drives."""

PATIENCE = 12.0
"""Seconds to wait for what stands in the way before giving it up as blocked."""

TIGHT_MARGIN = 0.04


def follow(
    view: View, start: Point, goal: Point, *, tolerance: float = 0.12, ends: bool = True
) -> Manoeuvre[View]:
    """Drive from ``start`` to ``goal``, a straight way on the map, round what stands in it.

    Args:
        view: the current tick.
        start: where the way begins, metres.
        goal: where it ends, metres.
        tolerance: metres from the goal, or beyond it, at which it counts as reached.
        ends: whether to slow down towards the goal, for a turn or a stop.

    Raises:
        WayBlocked: something stood in the way for longer than `PATIENCE`.
    """
    waited = 0.0
    while not _reached(view, start, goal, tolerance):
        error = heading_to(view, _carrot(view, start, goal))
        before = view.time
        if abs(error) > TURN_FIRST:
            view = yield Wheels(0.0, turn_rate(error))
            continue
        wheels = _steer(view, goal, error, ends=ends)
        if wheels.speed == 0.0:
            view = yield from _aside(view, error)
            waited += max(0.0, view.time - before)
        else:
            view = yield wheels
            waited = max(0.0, waited - 0.5 * (view.time - before))
        if waited > PATIENCE:
            raise WayBlocked(_ahead(view, 0.8))
    return view


def _steer(view: View, goal: Point, error: float, *, ends: bool) -> Wheels:
    distance = math.dist(view.at, goal)
    top = min(TOP_SPEED, SLOW_SPEED + 0.7 * distance) if ends else TOP_SPEED
    echoes = view.echoes(within=ECHO_RANGE)
    reach = min(ECHO_RANGE, distance + 0.5)
    near = echoes[(echoes**2).sum(axis=1) < reach**2]
    choice = choose(near, error, top_speed=top)
    if choice.wheels.speed == 0.0:
        choice = choose(near, error, top_speed=SLOW_SPEED, margin=TIGHT_MARGIN)
    return choice.wheels


def _aside(view: View, error: float) -> Manoeuvre[View]:
    """No arc leads on: turn towards an open side, or else stand and look again."""
    turn = widest_turn(view.echoes(within=ECHO_RANGE), error)
    if turn is None or abs(turn) < 0.15:
        return (yield STOP)
    view = yield from turn_by(view, turn)
    return (yield Wheels(SLOW_SPEED, 0.0))


def _reached(view: View, start: Point, goal: Point, tolerance: float) -> bool:
    """Whether the robot is at the goal, or has passed it closely enough."""
    if math.dist(view.at, goal) < tolerance:
        return True
    length = math.dist(start, goal)
    if length < 0.05:
        return math.dist(view.at, goal) < max(tolerance, 0.2)
    along = _along(view, start, goal)
    return along > length and math.dist(view.at, goal) < 3.0 * tolerance


def _along(view: View, start: Point, goal: Point) -> float:
    dx, dy = goal[0] - start[0], goal[1] - start[1]
    length = math.hypot(dx, dy)
    return ((view.pose[0] - start[0]) * dx + (view.pose[1] - start[1]) * dy) / length


def _carrot(view: View, start: Point, goal: Point) -> Point:
    length = math.dist(start, goal)
    if length < 0.05:
        return goal
    share = min(1.0, max(0.0, (_along(view, start, goal) + CARROT) / length))
    return (start[0] + share * (goal[0] - start[0]), start[1] + share * (goal[1] - start[1]))


def _ahead(view: View, metres: float) -> Point:
    x, y, theta = view.pose
    return (x + metres * math.cos(theta), y + metres * math.sin(theta))
