"""A robot that is not sure of its goal looks round before it says that it has arrived."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from corridor import Corridor

from navigate.driving import View
from navigate.driving._view import Astray
from navigate.driving._wander import LOOK_SECONDS, SURE, make_sure

UNSURE = View(
    time=0.0,
    pose=(0.0, 0.0, 0.0),
    odom=(0.0, 0.0, 0.0),
    ranges=np.full(24, np.inf),
    fresh=0,
    bump=0,
    echoes=np.empty((0, 2)),
    goal_mass=SURE - 0.2,
)


def looking(view, *, sure_at):
    """What `make_sure` does with the wheels; belief comes to the goal at a time in seconds."""
    course, wheels, time = make_sure(view), [], 0.0
    try:
        wheels.append(next(course))
        while True:
            time += 0.1
            mass = SURE if time >= sure_at else view.goal_mass
            wheels.append(course.send(replace(view, time=time, goal_mass=mass)))
    except StopIteration:
        return wheels


def test_sure_of_the_goal_it_has_arrived_at_once():
    assert looking(replace(UNSURE, goal_mass=SURE), sure_at=0.0) == []


def test_unsure_of_the_goal_it_looks_round_until_belief_is_there():
    wheels = looking(UNSURE, sure_at=4.0)
    assert all(one.speed == 0.0 for one in wheels)
    assert any(one.turn != 0.0 for one in wheels)
    assert 40 <= len(wheels) < 10.0 * LOOK_SECONDS


def test_where_belief_stays_thin_it_takes_the_tracked_pose_after_a_look():
    wheels = looking(UNSURE, sure_at=math.inf)
    assert 10.0 * LOOK_SECONDS < len(wheels) < 20.0 * LOOK_SECONDS


def test_where_readings_contradict_the_goal_it_has_gone_astray():
    with pytest.raises(Astray):
        looking(replace(UNSURE, lost=True, goal_mass=1.0), sure_at=math.inf)


@pytest.mark.parametrize("tolerance", [0.1, 0.2])
def test_a_short_way_that_begins_elsewhere_is_driven_to_its_goal(tolerance):
    """The last step of a drive may be some centimetres from behind a door, where nobody was yet."""
    hall, goal = Corridor(), (0.54, 0.01)
    assert hall.drive_way((0.553, 0.085), goal, tolerance=tolerance) is None
    assert math.dist(hall.pose[:2], goal) < 0.3
