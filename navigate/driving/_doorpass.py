"""Passing a door: face it, look whether it is open, line up on the jambs, creep through.

The robot is 0.61 m wide and a door 0.9 m, so 14 cm are left on either side; the position
estimate and the map together are not that good, the jambs measured on the way are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from navigate.body import PITCH, RING_RADIUS, ROBOT_RADIUS, Pose, wrap
from navigate.driving._doorcompany import is_near, stands_in_way
from navigate.driving._doorframe import DoorFrame, Look
from navigate.driving._doorlog import DoorLog
from navigate.driving._doorlook import SecondLook, look_along
from navigate.driving._safety import GENTLE, is_touching
from navigate.driving._turning import BACK_SPEED, is_behind, turn_rate
from navigate.driving._view import (
    STOP,
    Bumped,
    DoorMissed,
    DoorObstructed,
    DoorShut,
    Manoeuvre,
    OffCourse,
    View,
    Wheels,
)
from navigate.maps import Passage
from xavier_sim.messages import SONAR_COUNT

DOOR_PATIENCE = 40.0
"""Simulated seconds that the robot waits before a shut door."""

COMPANY_PATIENCE = 15.0
"""The same for somebody who stands in it: they may be waiting for the robot to make room."""

LOOK_AFTER, LOOK_AGAIN = 4.0, 14.0
"""Seconds before a door that seems shut after which the robot looks along the wall, and for
another time."""

BEYOND = 0.7
"""Metres behind the line at which a door is passed: the place of a room."""

APPROACH_SPEED, CREEP_SPEED = 0.36, 0.25
SLOWEST, SPEED_PER_METRE = 0.12, 2.0
"""Metres per second at which it comes to stand behind a door at least, and for each metre left."""

OFF_JAMBS = 0.5
"""Metres before or behind the line from which no jamb is right beside the robot."""

OPEN_DEPTH = 0.35
"""Metres behind the line that must be seen free for the door to count as open."""

CLEAR = 0.4 + ROBOT_RADIUS - RING_RADIUS
"""A front reading below this means that somebody or something is right ahead."""

LINED_UP = 0.07
"""Metres off the middle with which the robot may enter a door."""

COMMITTED = -0.42
"""Metres before the line at which the robot decides whether it is lined up."""

EYES = (0, 1, -1, 2, -2, 3, -3)
"""Sonars that look at a door, those first for which the robot turns the least."""

TRIES = 3
BACK_TO, BACK_SECONDS = -0.85, 17.0
"""Metres before the line from which a new try begins, and how long backing may take."""

AMONG_JAMBS = ROBOT_RADIUS + 0.15
"""Metres before or behind the line within which what the robot touches ahead may be a jamb."""

TOUCHED_DOUBT = (0.05, math.radians(6.0))
"""Metres and radians by which a pose is in doubt that led the robot into a jamb."""

ASIDE = 0.1
"""Metres beside the axis to which the robot backs out before it tries again."""

TOO_NEAR = -0.6
"""Metres before the line from which on the robot cannot line up any more: it backs out first."""

FACED, FACE_SECONDS = 0.03, 8.0
"""Radians off within which the robot faces a door, and how long turning may take."""

ONWARD, STANDING_SECONDS = 0.03, 6.0
"""Metres that count as getting on, and seconds without them after which it does not."""


class Passed(NamedTuple):
    """The tick at which a door is passed, and which way the robot looks by its jambs, if known."""

    view: View
    look: Look | None


class Outside(NamedTuple):
    """The tick at which the robot is out of a door again, and where it is and looks, if known."""

    view: View
    pose: Pose | None
    look: Look | None


def pass_door(view: View, door: Passage, sign: float, log: DoorLog) -> Manoeuvre[Passed]:
    """Pass ``door`` in the direction ``sign`` along its normal, up to `BEYOND` behind it.

    A try that ends out of line, or on which the robot does not get on, is followed by another
    one from farther off and from a little to the side, where the jambs are seen anew.

    Raises:
        DoorShut: it is closed, and stayed so.
        DoorObstructed: somebody stands in it.
        OffCourse: it is open, but elsewhere than the robot believed.
        DoorMissed: the robot did not get into line with it.
    """
    frame = DoorFrame(door, sign, view)
    if TOO_NEAR < frame.locate(view.odom)[0] < 0.0:
        view = yield from _retreat(view, frame)
    for attempt in range(TRIES):
        log.try_door(door.name)
        if frame.locate(view.odom)[0] < COMMITTED + 0.1:
            view = yield from _face(view, frame)
            view = yield from _await_open(view, frame)
        view = yield from _creep(view, frame, last=attempt == TRIES - 1)
        if frame.locate(view.odom)[0] >= BEYOND - 0.02:
            return Passed(view, frame.orient(view.odom))
        if frame.locate(view.odom)[0] > COMMITTED + 0.1:
            log.get_stuck(door.name)
        # Jambs that were mistaken for others have led astray.
        frame = DoorFrame(door, sign, view)
        view = yield from _retreat(view, frame, aside=ASIDE * (1.0 - 2.0 * (attempt % 2)))
    raise DoorMissed(door.name)


def is_among_jambs(met: Bumped, door: Passage, sign: float) -> bool:
    """Whether a contact on the way through a door is likely one with its jambs."""
    ahead = DoorFrame(door, sign, met.view).locate(met.view.odom)[0]
    return abs(ahead) < AMONG_JAMBS and not is_behind(met.direction)


def back_out(view: View, door: Passage, sign: float) -> Manoeuvre[Outside]:
    """Back out of a door after a touch of its jambs, and find out where the robot is.

    Light shows the wall and the opening as the robot turns before it, wherever it took them to be.
    """
    frame = DoorFrame(door, sign, view, heading_sigma=TOUCHED_DOUBT[1])
    view = yield from _retreat(view, frame)
    if view.lost or frame.locate(view.odom)[0] > COMMITTED:
        return Outside(view, None, None)
    if not view.sights:
        view = yield from _face(view, frame)
        return Outside(view, None, frame.orient(view.odom))
    view, seen, _ = yield from look_along(view, frame)
    if seen is not None and not seen.is_at(view.pose):
        return Outside(view, seen.pose, None)
    return Outside(view, None, frame.orient(view.odom))


def _face(view: View, frame: DoorFrame) -> Manoeuvre[View]:
    """Turn to the door, and measure what comes into view meanwhile."""
    until = view.time + FACE_SECONDS
    while view.time < until:
        frame.measure(view)
        ahead, left, turned = frame.locate(view.odom)
        aim = math.atan2(-left, max(0.5, -ahead)) if abs(left) > 0.05 else 0.0
        error = wrap(0.6 * aim - turned)
        if abs(error) < FACED:
            break
        view = yield Wheels(0.0, turn_rate(error))
    return view


def _await_open(view: View, frame: DoorFrame) -> Manoeuvre[View]:
    """Look with the front sonar until two readings running say that the door is open.

    Light that is seen to go through it says so too, and also where the door is instead. Where
    nothing but its neighbours stands in for the front sonar, they hear the jambs of an open door
    as if it was shut: then the robot turns to look with the next sonar that is sound, and back.
    """
    began, sees_open, eye = view.time, 0, 0
    look_at, obstructed = began + LOOK_AFTER, False
    while sees_open < 2:
        if obstructed and view.time - began > COMPANY_PATIENCE:
            raise DoorObstructed(frame.door.name, frame.door.centre, view.time - began)
        if view.time - began > DOOR_PATIENCE:
            raise DoorShut(frame.door.name, view.time - began)
        if view.time >= look_at and view.sights:
            view, door, obstructed = yield from _look_again(view, frame)
            if door is not None:
                break
            look_at = view.time + LOOK_AGAIN
        eye = _eye(view)
        error = _off_door(view, frame, eye) if eye else 0.0
        if abs(error) > FACED:
            view = yield Wheels(0.0, turn_rate(error))
            continue
        if view.is_fresh(eye % SONAR_COUNT):
            sees_open = sees_open + 1 if _open(view, frame, eye) else 0
        view = yield STOP
    return (yield from _face(view, frame)) if eye else view


def _look_again(view: View, frame: DoorFrame) -> Manoeuvre[SecondLook]:
    """Look along the wall whether the door is open after all.

    Raises:
        OffCourse: it is, but elsewhere than it was looked for.
    """
    look = yield from look_along(view, frame)
    door = look.door
    if door is not None and not door.is_as_believed:
        raise OffCourse(frame.door.name, door.pose, metres=door.off, radians=door.turned)
    view = yield from _face(look.view, frame)
    return look._replace(view=view)


def _eye(view: View) -> int:
    """The sonar to look with: the front one, or the nearest sound one, negative to the right."""
    return next((n for n in EYES if not view.is_blind(n % SONAR_COUNT)), 0)


def _off_door(view: View, frame: DoorFrame, eye: int) -> float:
    """Radians to turn to the left for a sonar to look at the middle of the door."""
    ahead, left, turned = frame.locate(view.odom)
    return wrap(math.atan2(-left, max(0.5, -ahead)) - eye * PITCH - turned)


def _open(view: View, frame: DoorFrame, eye: int) -> bool:
    distance = -frame.locate(view.odom)[0] - RING_RADIUS
    return bool(view.ranges[eye] > distance + OPEN_DEPTH)


def _creep(view: View, frame: DoorFrame, *, last: bool) -> Manoeuvre[View]:
    """Drive along the axis of the door; returns behind it, or before it when it gets no farther.

    That is when the robot is out of line where it may not be any more, or stands too long.
    """
    farthest, since = -math.inf, view.time
    checked = frame.locate(view.odom)[0] > COMMITTED
    while True:
        frame.measure(view)
        ahead, left, turned = frame.locate(view.odom)
        if ahead > farthest + ONWARD:
            farthest, since = ahead, view.time
        if ahead >= BEYOND - 0.02 or view.time - since > STANDING_SECONDS:
            return view
        if not checked and ahead > COMMITTED:
            checked = True
            if abs(left) > (1.4 if last else 1.0) * LINED_UP:
                return view
        if ahead < BEYOND - 0.2 and _hindered(view, frame):
            view = yield from _await_clear(view, frame)
            since = view.time
        else:
            view = yield _gently(view, (ahead, left, turned), _steer(ahead, left, turned))


def _steer(ahead: float, left: float, turned: float) -> Wheels:
    inside = abs(ahead) < 0.35
    limit = 0.12 if inside else 0.4
    wanted = max(-limit, min(limit, -1.6 * left))
    error = wrap(wanted - turned)
    speed = CREEP_SPEED if -0.6 < ahead < 0.35 else APPROACH_SPEED
    remaining = max(SLOWEST, SPEED_PER_METRE * (BEYOND - ahead))
    return Wheels(
        min(speed, remaining) * max(0.0, 1.0 - abs(error) / 0.5),
        turn_rate(error, top=0.8),
        narrow=True,
    )


def _gently(view: View, robot: tuple[float, float, float], wheels: Wheels) -> Wheels:
    """No faster than somebody may be touched, while somebody is near who is no jamb."""
    touching = abs(robot[0]) > OFF_JAMBS and is_touching(view, backward=False)
    if touching or is_near(robot, view.ranges):
        return wheels._replace(speed=min(GENTLE, wheels.speed))
    return wheels


def _await_clear(view: View, frame: DoorFrame) -> Manoeuvre[View]:
    """Somebody is in the way: stop, and give them the time to leave it."""
    began = view.time
    while _hindered(view, frame):
        if view.time - began > COMPANY_PATIENCE:
            view = yield from _retreat(view, frame)
            raise DoorObstructed(frame.door.name, frame.door.centre, view.time - began)
        view = yield STOP
    return view


def _hindered(view: View, frame: DoorFrame) -> bool:
    """Whether something is right ahead, or in the way of one side of the robot."""
    return bool(view.ranges[0] < CLEAR) or stands_in_way(frame.locate(view.odom), view.ranges)


def _retreat(view: View, frame: DoorFrame, *, aside: float = 0.0) -> Manoeuvre[View]:
    """Back out to where a new try can begin, ``aside`` metres to the left of the axis."""
    until = view.time + BACK_SECONDS
    while view.time < until:
        ahead, left, turned = frame.locate(view.odom)
        if ahead < BACK_TO:
            break
        frame.measure(view)
        off = left - (aside if ahead < COMMITTED else 0.0)
        error = wrap(max(-0.35, min(0.35, 2.0 * off)) - turned)
        view = yield Wheels(-BACK_SPEED, turn_rate(error, top=0.6), narrow=True)
    return view
