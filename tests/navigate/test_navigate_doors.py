"""Doors seen from near: where a laser sees the wall end, and what the filter makes of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navigate.driving import View
from navigate.driving._doorframe import DoorFrame
from navigate.driving._doorsight import look_at_door
from navigate.maps import Floor, load_plan
from xavier_sim.messages import STRIPER_AHEAD, STRIPER_BEAMS, STRIPER_VIEW

FLOOR = Floor(load_plan())
DOOR = FLOOR.doors["d-5303"]
HALF = DOOR.width / 2
BEAMS = np.linspace(-STRIPER_VIEW / 2, STRIPER_VIEW / 2, STRIPER_BEAMS)
SILENT = np.full(24, np.inf)


def striper(ahead: float, left: float, turned: float, *, shut: bool = False) -> np.ndarray:
    """What the striper reads before a door in an endless wall, with nothing behind it."""
    looks = turned + BEAMS
    x, y = ahead + STRIPER_AHEAD * math.cos(turned), left + STRIPER_AHEAD * math.sin(turned)
    ranges = -x / np.cos(looks)
    open_there = np.abs(y + ranges * np.sin(looks)) < HALF
    return np.where(open_there & (not shut), np.inf, ranges)


def test_where_the_wall_ends_are_the_jambs():
    right = look_at_door((-1.2, 0.1, -0.45), striper(-1.2, 0.1, -0.45))
    assert right.right_jambs == pytest.approx([-HALF], abs=0.03)
    assert right.left_jambs == []
    left = look_at_door((-1.2, 0.1, 0.4), striper(-1.2, 0.1, 0.4))
    assert left.left_jambs == pytest.approx([HALF], abs=0.03)
    assert np.abs(left.wall[:, 0]).max() < 1e-9
    assert (left.wall[:, 1] > HALF).all()


def test_a_shut_door_has_no_jambs_and_neither_has_one_that_is_passed():
    shut = look_at_door((-1.2, 0.0, -0.4), striper(-1.2, 0.0, -0.4, shut=True))
    assert shut.right_jambs == shut.left_jambs == []
    assert len(shut.wall) > 0
    passed = look_at_door((0.2, 0.0, 0.0), np.full(STRIPER_BEAMS, 1.0))
    assert len(passed.wall) == len(passed.right_jambs) == len(passed.left_jambs) == 0


def test_turning_to_a_door_measures_it_whatever_map_and_position_say():
    sign, (x, y) = 1.0, DOOR.centre
    facing = math.atan2(DOOR.normal[1], DOOR.normal[0])
    for off, askew in ((0.12, 0.0), (-0.12, 0.03), (0.05, -0.04)):
        at = (x - 1.2 * DOOR.normal[0], y - 1.2 * DOOR.normal[1])
        frame = None
        for turned in np.arange(-1.2, 0.01, 0.06):
            odom = (*at, facing + float(turned))
            view = View(
                time=0.0,
                pose=(at[0] - off * DOOR.normal[1], at[1] + off * DOOR.normal[0], odom[2] + askew),
                odom=odom,
                ranges=SILENT,
                fresh=0,
                bump=0,
                echoes=np.zeros((0, 2)),
                striper=striper(-1.2, 0.0, float(turned)),
            )
            frame = frame or DoorFrame(DOOR, sign, view)
            frame.measure(view)
        ahead, left, error = frame.locate((*at, facing))
        assert (ahead, left) == pytest.approx((-1.2, 0.0), abs=0.03)
        assert abs(error) < 0.02
        assert frame.doubt < 0.04


def test_dead_reckoning_makes_the_frame_of_a_door_doubtful():
    view = View(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), SILENT, 0, 0, np.zeros((0, 2)))
    frame = DoorFrame(DOOR, 1.0, view)
    before = frame.doubt
    frame.measure(View(0.1, (0.5, 0.0, 1.0), (0.5, 0.0, 1.0), SILENT, 0, 0, np.zeros((0, 2))))
    assert frame.doubt > before
