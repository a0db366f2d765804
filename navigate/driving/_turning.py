"""Manoeuvres on the spot: turning, waiting, looking round, backing off."""

from __future__ import annotations

import math

from navigate.body import wrap
from navigate.driving._view import STOP, Bumped, Manoeuvre, View, Wheels
from navigate.maps import Point

TURN_GAIN = 2.0
TOP_TURN = 1.2
"""Radians per second on the spot."""

BACK_SPEED = 0.1
"""Metres per second at which nobody behind is hurt, who is heard least there."""

BACK_SECONDS = 5.0
GIVE_WAY, GIVE_WAY_SECONDS = 0.5, 8.0
"""Metres to make room for whoever stands in the way, and seconds that it may take."""

ROOM_SECONDS = 5.0
"""How long others are let use it."""


def turn_rate(error: float, *, top: float = TOP_TURN) -> float:
    """The turn rate that takes out a heading error without overshooting."""
    slow = math.copysign(min(0.06, abs(error)), error)
    return max(-top, min(top, TURN_GAIN * error + slow))


def turn_by(view: View, angle: float, *, within: float = 0.03) -> Manoeuvre[View]:
    """Turn on the spot by ``angle`` radians as odometry tells; at most eight seconds."""
    goal, until = view.odom[2] + angle, view.time + 8.0
    error = wrap(goal - view.odom[2])
    while abs(error) > within and view.time < until:
        view = yield Wheels(0.0, turn_rate(error))
        error = wrap(goal - view.odom[2])
    return view


def wait(view: View, seconds: float) -> Manoeuvre[View]:
    """Stand still."""
    until = view.time + seconds
    while view.time < until - 1e-6:
        view = yield STOP
    return view


def is_behind(direction: float) -> bool:
    """Whether a contact is one to drive forward from."""
    return math.cos(direction) <= -0.2


def back_off(view: View, direction: float, metres: float = 0.25) -> Manoeuvre[View]:
    """Drive straight away from a contact at ``direction``, as far as nothing else is touched."""
    sign = 1.0 if is_behind(direction) else -1.0
    start, until = view.odom, view.time + BACK_SECONDS
    while view.time < until and math.dist(start[:2], view.odom[:2]) < metres:
        try:
            view = yield Wheels(sign * BACK_SPEED, 0.0, narrow=True)
        except Bumped as contact:
            view = contact.view
            if math.cos(contact.direction) * sign > 0.3:
                break
    return (yield from wait(view, 0.4))


def give_way(view: View, at: Point) -> Manoeuvre[View]:
    """Turn away from what is at a point of the map and drive off a little, as far as is free."""
    away = math.atan2(view.pose[1] - at[1], view.pose[0] - at[0])
    view = yield from turn_by(view, wrap(away - view.pose[2]))
    start, until = view.odom, view.time + GIVE_WAY_SECONDS
    while view.time < until and math.dist(start[:2], view.odom[:2]) < GIVE_WAY:
        view = yield Wheels(BACK_SPEED, 0.0)
    return (yield from wait(view, ROOM_SECONDS))
