"""A lost robot goes on as if it were where it supposes, until it is found or that proves wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from navigate.driving import View, Wheels
from navigate.driving._drive import Drive, GoalFailedError
from navigate.driving._scout import FAR_OFF, Scout
from navigate.driving._view import Bumped, DoorMissed
from navigate.driving._wander import HEADWAY_SECONDS, LISTEN_METRES, find_oneself
from navigate.maps import Floor, load_plan
from navigate.messages import NavigationFailure

SUPPOSING = View(
    time=0.0,
    pose=(0.0, 0.0, 0.0),
    odom=(0.0, 0.0, 0.0),
    ranges=np.full(24, 3.0),
    fresh=0,
    bump=0,
    echoes=np.empty((0, 2)),
    lost=True,
    supposed=True,
)
FLOOR = Floor(load_plan())
AHEAD = Wheels(0.4, 0.0)


class Ways:
    """Notes where the robot is sent, and drives straight on."""

    def __init__(self, trouble=None):
        self.goals, self.trouble = [], trouble

    def __call__(self, drive, view):
        self.goals.append(drive.goal)
        while True:
            assert not view.lost
            view = yield AHEAD
            if self.trouble is not None:
                raise self.trouble


def search(ways, view=SUPPOSING):
    """A search on a drive to the origin, and that drive."""
    drive = Drive((0.0, 0.0), view.time)
    return find_oneself(view, Scout(drive, ways, FLOOR)), drive


def ticks(course, view, count, *, speed=0.4):
    """Send so many views of a robot that moves as it is told to, at ``speed`` at most."""
    wheels, all_wheels = next(course), []
    for _ in range(count):
        x = view.odom[0] + 0.1 * min(wheels.speed, speed)
        view = replace(view, time=view.time + 0.1, odom=(x, 0.0, 0.0), pose=(x, 0.0, 0.0))
        wheels = course.send(view)
        all_wheels.append(wheels)
    return view, all_wheels


def test_it_drives_as_supposed_and_stands_now_and_then_to_listen():
    ways = Ways()
    course, _ = search(ways)
    view, wheels = ticks(course, SUPPOSING, 200)
    assert ways.goals == [(0.0, 0.0)]
    assert view.odom[0] > 2 * LISTEN_METRES
    stood = sum(one.speed == 0.0 for one in wheels)
    assert 20 <= stood < 80


def test_once_found_it_searches_no_more():
    course, drive = search(Ways())
    view, _ = ticks(course, SUPPOSING, 20)
    with pytest.raises(StopIteration):
        course.send(replace(view, lost=False, supposed=False))
    assert not drive.findings.refuted


def test_a_way_on_which_it_does_not_get_on_refutes_what_it_supposed():
    course, drive = search(Ways())
    ticks(course, SUPPOSING, round(10 * HEADWAY_SECONDS) - 2, speed=0.0)
    assert not drive.findings.refuted
    course, drive = search(Ways())
    ticks(course, SUPPOSING, round(10 * HEADWAY_SECONDS) + 2, speed=0.0)
    assert drive.findings.refuted


def test_a_door_that_is_not_there_refutes_it_as_well_and_ends_no_drive():
    course, drive = search(Ways(DoorMissed("d-5303")))
    ticks(course, SUPPOSING, 2)
    assert drive.findings.refuted
    assert drive.troubles == []


def test_at_the_goal_and_still_not_found_it_goes_where_more_is_to_be_told():
    goals = []

    def at_once(drive, view):
        goals.append(drive.goal)
        return view
        yield AHEAD

    course, _ = search(at_once)
    ticks(course, SUPPOSING, 20)
    assert goals[0] == (0.0, 0.0)
    assert np.hypot(*goals[1]) > FAR_OFF


def test_touches_are_counted_and_backed_off_from():
    course, drive = search(Ways())
    view, _ = ticks(course, SUPPOSING, 5)
    touched = Bumped(0.0, view)
    assert course.throw(touched).speed < 0.0
    assert drive.troubles == [touched]
    course, drive = search(Ways())
    drive.troubles += [touched] * 6
    next(course)
    with pytest.raises(GoalFailedError) as ended:
        course.throw(touched)
    assert ended.value.reason is NavigationFailure.BUMP
