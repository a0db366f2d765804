"""The grid around the robot, and what virtual sensors make of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from navigate_rings import TRUE, ring

from navigate.body import (
    BEARINGS,
    Front,
    LocalGrid,
    Motion,
    MotionReports,
    Moved,
    Side,
    Turned,
    find_axis,
    look_aside,
    look_front,
    motion_between,
    wrap,
)


def heard_along(start, end, steps=20, turned=0.0):
    """A grid after a drive between two poses of the true floor, in a frame that is ``turned``."""
    grid = LocalGrid()
    cos, sin = math.cos(turned), math.sin(turned)
    for share in np.linspace(0.0, 1.0, steps):
        x, y, theta = (a + share * (b - a) for a, b in zip(start, end, strict=True))
        pose = (x * cos - y * sin, x * sin + y * cos, theta + turned)
        grid.follow(*pose[:2])
        grid.hear(pose, BEARINGS, ring(x, y, theta))
    return grid, pose


def test_a_corridor_has_walls_on_both_sides_and_a_small_opening_at_a_door():
    north = math.pi / 2
    x, door = 7.57, TRUE.doors["d-5305"].centre[1]
    grid, pose = heard_along((x, door - 3.6, north), (x, door - 1.2, north))
    assert look_aside(grid, pose, left=True) == Side.WALL
    grid, pose = heard_along((x, door - 2.0, north), (x, door + 0.7, north))
    assert look_aside(grid, pose, left=True) == Side.SMALL


def test_a_crossing_is_wider_than_a_door():
    north = math.pi / 2
    grid, pose = heard_along((7.57, 34.5, north), (7.57, 38.2, north))
    assert look_aside(grid, pose, left=False) in {Side.MEDIUM, Side.LARGE}


def test_the_end_of_a_room_is_a_wall_ahead():
    x, y = TRUE.place("r-5305")
    grid, pose = heard_along((x, y, math.pi), (3.0, y, math.pi))
    assert look_front(grid, pose) == Front.WALL


def test_the_striper_tells_free_floor_and_what_stands_before_it():
    pose = (0.3, -0.4, 0.7)
    grid = seen(pose, np.full(31, np.inf))
    assert look_front(grid, pose) == Front.CLEAR
    grid = seen(pose, np.full(31, 1.2))
    assert look_front(grid, pose) == Front.WALL
    assert grid.evidence(*at(pose, 1.45)) > 0.0
    assert grid.evidence(*at(pose, 0.9)) < 0.0
    assert grid.evidence(*at(pose, 2.0)) == 0.0


def test_a_robot_without_a_striper_sees_nothing_with_it():
    grid = LocalGrid()
    grid.see((0.0, 0.0, 0.0), np.empty(0))
    assert look_front(grid, (0.0, 0.0, 0.0)) is None


def seen(pose, beams):
    grid = LocalGrid()
    for _ in range(3):
        grid.see(pose, beams)
    return grid


def at(pose, ahead):
    x, y, theta = pose
    return np.array(x + ahead * math.cos(theta)), np.array(y + ahead * math.sin(theta))


def test_what_was_not_heard_is_not_reported():
    grid = LocalGrid()
    assert look_front(grid, (0.0, 0.0, 0.0)) is None
    assert look_aside(grid, (0.0, 0.0, 0.0), left=True) is None
    assert find_axis(grid) is None


def test_what_is_left_behind_is_forgotten():
    grid = LocalGrid()
    grid.hear((0.0, 0.0, 0.0), BEARINGS, np.full(24, 1.0))
    assert len(grid.occupied()) > 20
    before = grid.occupied()
    grid.follow(1.0, 0.0)
    assert len(grid.occupied()) == len(before)
    grid.follow(9.0, 0.0)
    assert len(grid.occupied()) == 0
    assert (grid.evidence(before[:, 0], before[:, 1]) == 0.0).all()


@settings(max_examples=10, deadline=None)
@given(st.floats(-3.0, 3.0))
def test_the_walls_axis_is_found_whatever_the_frame(turned):
    grid, _ = heard_along((7.57, 20.0, 1.6), (7.57, 23.0, 1.5), turned=turned)
    axis = find_axis(grid)
    assert axis is not None
    assert abs(wrap(4.0 * (axis - turned))) / 4.0 < math.radians(4.0)


def drive(reports, metres, turn=0.0, steps=20):
    out = []
    for _ in range(steps):
        out += reports.move(Motion(metres / steps, 0.0, turn / steps))
    return out


def test_motions_are_reported_by_the_metre_and_the_quarter():
    reports = MotionReports()
    assert drive(reports, 2.05) == [Moved(0), Moved(0)]
    assert drive(reports, 0.0, math.pi / 2) == [Turned(1)]
    assert drive(reports, 1.05) == [Moved(0)]
    assert drive(reports, -1.2) == [Moved(2)]
    assert drive(reports, 0.0, -math.pi) == [Turned(-1), Turned(-1)]


def test_weaving_is_no_turn():
    reports = MotionReports()
    for turn in (0.5, -1.0, 1.0, -0.5):
        assert drive(reports, 0.05, turn) == []
    assert reports.turned == pytest.approx(0.0)


def test_an_axis_that_is_told_anew_does_not_turn_the_robot():
    reports = MotionReports()
    reports.align(math.pi / 2 + 0.1)
    assert reports.axis == pytest.approx(0.1)
    assert reports.move(motion_between((0, 0, 0), (0, 0, 0))) == []
