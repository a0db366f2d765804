"""Looking for oneself: turning on the spot, then going where there is room, until found.

What a lost robot hears at one place may be heard at many; a few metres farther on it is not.
"""

from __future__ import annotations

import math

import numpy as np

from navigate.body import BEARINGS
from navigate.driving._cvm import Window, choose
from navigate.driving._drive import GoalFailedError
from navigate.driving._turning import turn_by, wait
from navigate.driving._view import Astray, Manoeuvre, View
from navigate.messages import NavigationFailure

SEARCH_SECONDS = 75.0
LOOK_SECONDS = 12.0
"""For how long the robot looks round before it goes somewhere else."""

LOOK_TURN, STAND_SECONDS = 0.7, 1.5
WANDER_SPEED = 0.25
WANDER_METRES, WANDER_SECONDS = 1.5, 10.0


def find_oneself(view: View) -> Manoeuvre[View]:
    """Turn, stand and go about until the position is found again.

    Raises:
        GoalFailedError: it was not, for `SEARCH_SECONDS`.
    """
    until = view.time + SEARCH_SECONDS
    while view.lost:
        if view.time > until:
            text = f"{Astray()}, wherever it looks"
            raise GoalFailedError(NavigationFailure.LOST, text, by_trouble=True)
        view = yield from _look_round(view)
        if view.lost:
            view = yield from _go_on(view)
    return view


def _look_round(view: View) -> Manoeuvre[View]:
    until = view.time + LOOK_SECONDS
    while view.lost and view.time < until:
        view = yield from wait(view, STAND_SECONDS)
        if view.lost:
            view = yield from turn_by(view, LOOK_TURN)
    return view


def _go_on(view: View) -> Manoeuvre[View]:
    """Turn to where there is most room, and drive there a little."""
    ring = np.minimum(np.where(np.isfinite(view.ranges), view.ranges, 0.0), 4.0)
    room = np.minimum(ring, np.minimum(np.roll(ring, 1), np.roll(ring, -1)))
    view = yield from turn_by(view, float(BEARINGS[int(room.argmax())]))
    start, until = view.odom, view.time + WANDER_SECONDS
    while view.time < until and math.dist(start[:2], view.odom[:2]) < WANDER_METRES:
        window = Window.around(view.speed, view.turn, WANDER_SPEED)
        view = yield choose(view.echoes, 0.0, window).wheels
    return view
