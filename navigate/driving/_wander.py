"""Looking for oneself: turning on the spot, then going on, until found.

What a lost robot hears at one place may be heard at many; a few metres farther on it is not. It
goes where its belief says, all in all, that the goal is nearest, or else where there is room.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from navigate.body import BEARINGS, PITCH, wrap
from navigate.driving._cvm import Window, choose
from navigate.driving._drive import GoalFailedError
from navigate.driving._scout import Scout
from navigate.driving._turning import back_off, turn_by, wait
from navigate.driving._view import (
    STOP,
    Astray,
    Bumped,
    DoorTrouble,
    Manoeuvre,
    View,
    WayBlocked,
)
from navigate.maps import Floats
from navigate.messages import NavigationFailure

SEARCH_SECONDS = 75.0
ADVISED_SECONDS = 480.0
"""The same for a robot whose belief says where to go: it gets about, 100 metres and more."""

LOOK_SECONDS = 12.0
"""For how long the robot looks round before it goes somewhere else."""

LOOK_TURN, STAND_SECONDS = 0.7, 1.5
WANDER_SPEED = 0.25
WANDER_METRES, WANDER_SECONDS = 1.5, 10.0
ADVISED_SPEED, ADVISED_METRES = 0.4, 3.0
"""How fast and how far it goes at a time where it is told to."""

HEADWAY, HEADWAY_SECONDS = 1.0, 20.0
"""Metres by which it must get on within so many seconds while it goes as it supposes."""

LISTEN_METRES = 2.5
"""Metres after which it stands meanwhile to listen."""

JUMP = 0.5
"""Metres by which the pose must change at once to be another one."""

OPEN = 1.0
"""Metres that must be free there."""

SURE = 0.5
"""Share of belief at the goal below which the robot looks round before it says that it arrived."""


def make_sure(view: View) -> Manoeuvre[View]:
    """At the goal, look round while little belief is there: readings settle it either way.

    Cells alone do not: among people belief is thin at right places as well, so that after
    `LOOK_SECONDS` a tracked pose that is not contradicted counts.

    Raises:
        Astray: the robot is lost.
    """
    until = view.time + LOOK_SECONDS
    while not view.lost and view.goal_mass < SURE and view.time <= until:
        view = yield from wait(view, STAND_SECONDS)
        view = yield from turn_by(view, LOOK_TURN)
    if view.lost:
        raise Astray
    return view


def find_oneself(view: View, scout: Scout) -> Manoeuvre[View]:
    """Turn, stand and go about until the position is found again.

    Args:
        view: what is seen now.
        scout: drives as if the robot were where a view says. It is asked to while readings fit
            that, and only whether the robot is there or somewhere like it is in doubt.

    Raises:
        GoalFailedError: it was not, for `SEARCH_SECONDS`, or `ADVISED_SECONDS` where its belief
            says where to go.
    """
    began, advised, touched = view.time, False, False
    while view.lost:
        advised |= view.advice is not None or view.supposed
        if view.time > began + (ADVISED_SECONDS if advised else SEARCH_SECONDS):
            text = f"{Astray()}, wherever it looks"
            raise GoalFailedError(NavigationFailure.LOST, text, by_trouble=True)
        try:
            view = yield from (_go_on(view) if touched else _search_on(view, scout))
            touched = False
        except Bumped as contact:
            scout.meet(contact)
            touched = True
            view = yield from back_off(contact.view, contact.direction)
    return view


def _search_on(view: View, scout: Scout) -> Manoeuvre[View]:
    if view.supposed:
        return (yield from _go_as_supposed(view, scout))
    view = yield from _look_round(view)
    if view.lost and not view.supposed:
        view = yield from (_go_on(view) if view.advice is None else _go_as_told(view))
    return view


def _go_as_supposed(view: View, scout: Scout) -> Manoeuvre[View]:
    """Drive as if the robot were found: to the goal, and on from there to where more is told."""
    try:
        view = yield from _suppose(view, scout.to_goal(replace(view, lost=False)))
        if view.lost and view.supposed:
            view = yield from wait(view, STAND_SECONDS)
            view = yield from _suppose(view, scout.elsewhere(replace(view, lost=False)))
    except _Refuted:
        scout.refute()
        view = yield STOP
        view = yield from _go_as_told(view)
    return view


def _suppose(view: View, course: Manoeuvre[View]) -> Manoeuvre[View]:
    """Drive a course as if the robot were found, and stand now and then to listen whether it is.

    Ends where it is found, or supposes to be elsewhere.

    Raises:
        _Refuted: there is no way where it should be.
    """
    listened = here = view.odom
    since = view.time
    try:
        wheels = next(course)
        while True:
            before, view = view, (yield wheels)
            if not (view.lost and view.supposed) or _jumped(before, view):
                return view
            if math.dist(here[:2], view.odom[:2]) > HEADWAY:
                here, since = view.odom, view.time
            if view.time > since + HEADWAY_SECONDS:
                raise _Refuted
            if math.dist(listened[:2], view.odom[:2]) > LISTEN_METRES:
                view = yield from wait(view, STAND_SECONDS)
                listened = view.odom
            wheels = course.send(replace(view, lost=False))
    except StopIteration:
        return view
    except (GoalFailedError, DoorTrouble, WayBlocked) as trouble:
        raise _Refuted from trouble
    finally:
        course.close()


class _Refuted(Exception):  # noqa: N818 -- an event on the way as well
    """The robot cannot be where it supposed to be."""


def _jumped(before: View, now: View) -> bool:
    """Whether the pose has changed otherwise than by how the robot moved."""
    moved = math.dist(before.odom[:2], now.odom[:2])
    return math.dist(before.pose[:2], now.pose[:2]) > moved + JUMP


def _look_round(view: View) -> Manoeuvre[View]:
    until = view.time + LOOK_SECONDS
    while view.lost and view.time < until and view.advice is None:
        view = yield from wait(view, STAND_SECONDS)
        if view.lost:
            view = yield from turn_by(view, LOOK_TURN)
    return view


def _go_on(view: View) -> Manoeuvre[View]:
    """Turn to where there is most room, and drive there a little."""
    view = yield from turn_by(view, float(BEARINGS[int(_room(view, silent=0.0).argmax())]))
    return (yield from _go_ahead(view, WANDER_SPEED, WANDER_METRES))


def _go_as_told(view: View) -> Manoeuvre[View]:
    """Stand and listen, then turn as belief says and drive there, if there is room."""
    view = yield from wait(view, STAND_SECONDS)
    if not view.lost or view.advice is None:
        return view
    ways = (view.advice, 0.0, math.pi / 2, -math.pi / 2, math.pi)
    room = _room(view, silent=4.0)
    free = [way for way in ways if room[round(way / PITCH) % len(room)] > OPEN]
    view = yield from turn_by(view, wrap(free[0] if free else math.pi))
    return (yield from _go_ahead(view, ADVISED_SPEED, ADVISED_METRES))


def _room(view: View, *, silent: float) -> Floats:
    """Metres that are free towards each sonar and its neighbours, 4 at most.

    ``silent`` is what counts where there is no echo: from far off, or glanced off a wall.
    """
    ring = np.minimum(np.where(np.isfinite(view.ranges), view.ranges, silent), 4.0)
    return np.minimum(ring, np.minimum(np.roll(ring, 1), np.roll(ring, -1)))


def _go_ahead(view: View, speed: float, metres: float) -> Manoeuvre[View]:
    """Drive on for so many metres, or as far as there is room, round what is in the way."""
    start, until = view.odom, view.time + WANDER_SECONDS
    while view.lost and view.time < until and math.dist(start[:2], view.odom[:2]) < metres:
        window = Window.around(view.speed, view.turn, speed)
        view = yield choose(view.echoes, 0.0, window).wheels
    return view
