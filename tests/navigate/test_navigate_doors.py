"""Doors seen from near: where a laser sees the wall end, and what the filter makes of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navigate.body import LIDAR, RING_RADIUS, STRIPER, Laser, Sight, wrap
from navigate.driving import View
from navigate.driving._doorcompany import is_near, stands_in_way
from navigate.driving._doorframe import DoorFrame
from navigate.driving._doorsight import look_at_door
from navigate.maps import Floor, load_plan

FLOOR = Floor(load_plan())
DOOR = FLOOR.doors["d-5303"]
HALF = DOOR.width / 2
SILENT = np.full(24, np.inf)


def beams(
    ahead: float, left: float, turned: float, *, shut: bool = False, laser: Laser = STRIPER
) -> np.ndarray:
    """What a laser reads before a door in an endless wall, with nothing behind it."""
    looks = turned + laser.bearings
    x, y = ahead + laser.ahead * math.cos(turned), left + laser.ahead * math.sin(turned)
    ranges = np.where(np.cos(looks) > 1e-3, -x / np.cos(looks).clip(1e-3), np.inf)
    open_there = np.abs(y + ranges * np.sin(looks)) < HALF
    return np.where(open_there & (not shut), np.inf, ranges)


def test_where_the_wall_ends_are_the_jambs():
    right = look_at_door((-1.2, 0.1, -0.45), STRIPER, beams(-1.2, 0.1, -0.45))
    assert right.right_jambs == pytest.approx([-HALF], abs=0.03)
    assert right.left_jambs == []
    left = look_at_door((-1.2, 0.1, 0.4), STRIPER, beams(-1.2, 0.1, 0.4))
    assert left.left_jambs == pytest.approx([HALF], abs=0.03)
    assert np.abs(left.wall[:, 0]).max() < 1e-9
    assert (left.wall[:, 1] > HALF).all()


def test_a_shut_door_has_no_jambs_and_neither_has_one_that_is_passed():
    shut = look_at_door((-1.2, 0.0, -0.4), STRIPER, beams(-1.2, 0.0, -0.4, shut=True))
    assert shut.right_jambs == shut.left_jambs == []
    assert len(shut.wall) > 0
    passed = look_at_door((0.2, 0.0, 0.0), STRIPER, np.full(STRIPER.beams, 1.0))
    assert len(passed.wall) == len(passed.right_jambs) == len(passed.left_jambs) == 0


@pytest.mark.parametrize("laser", [STRIPER, LIDAR])
def test_turning_to_a_door_measures_it_whatever_map_and_position_say(laser):
    sign, (x, y) = 1.0, DOOR.centre
    facing = math.atan2(DOOR.normal[1], DOOR.normal[0])
    for off, askew in ((0.12, 0.0), (-0.12, 0.03), (0.05, -0.04)):
        at = (x - 1.2 * DOOR.normal[0], y - 1.2 * DOOR.normal[1])
        frame = None
        for turned in np.arange(-1.2, 0.01, 0.06):
            odom = (*at, facing + float(turned))
            ranges = beams(-1.2, 0.0, float(turned), laser=laser)
            seen = Sight(ranges, np.zeros((laser.beams, 2)), SILENT)
            view = View(
                time=0.0,
                pose=(at[0] - off * DOOR.normal[1], at[1] + off * DOOR.normal[0], odom[2] + askew),
                odom=odom,
                ranges=SILENT,
                fresh=0,
                bump=0,
                echoes=np.zeros((0, 2)),
                sights=((laser, seen),),
            )
            frame = frame or DoorFrame(DOOR, sign, view)
            frame.measure(view)
        ahead, left, error = frame.locate((*at, facing))
        assert (ahead, left) == pytest.approx((-1.2, 0.0), abs=0.03)
        assert abs(error) < 0.03
        assert frame.doubt < 0.04
        look = frame.orient((*at, facing))
        assert abs(wrap(look.theta - facing)) < min(0.04, 2.5 * look.doubt)


def test_dead_reckoning_makes_the_frame_of_a_door_doubtful():
    view = View(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), SILENT, 0, 0, np.zeros((0, 2)))
    frame = DoorFrame(DOOR, 1.0, view)
    before = frame.doubt
    frame.measure(View(0.1, (0.5, 0.0, 1.0), (0.5, 0.0, 1.0), SILENT, 0, 0, np.zeros((0, 2))))
    assert frame.doubt > before


def heard(*seen: tuple[int, float]) -> np.ndarray:
    ranges = np.full(24, np.inf)
    for number, metres in seen:
        ranges[number] = metres
    return ranges


def test_who_stands_beside_the_way_to_a_door_is_in_it():
    beside = heard((22, 0.3), (23, 0.35))
    assert stands_in_way((-0.9, 0.0, 0.0), beside)
    assert not stands_in_way((-0.9, -0.3, 0.0), beside)
    assert not stands_in_way((-0.9, 0.0, 0.0), heard((22, 0.3)))
    assert not stands_in_way((-0.9, 0.0, 0.0), heard((22, 0.7), (23, 0.7)))


def test_jambs_are_in_nobodys_way():
    for ahead in (-0.8, -0.5, -0.3):
        tips = [(math.hypot(ahead, HALF), math.atan2(side * HALF, -ahead)) for side in (-1, 1)]
        ring = heard(
            *((round(angle / math.radians(15.0)) % 24, away - RING_RADIUS) for away, angle in tips)
        )
        assert np.isfinite(ring).sum() == 2
        assert not stands_in_way((ahead, 0.0, 0.0), ring)


def test_the_wall_round_the_corner_is_not_taken_for_that_of_the_door():
    corner, turned = 1.1, 1.2
    x, y = -0.7 + STRIPER.ahead * math.cos(turned), STRIPER.ahead * math.sin(turned)
    looks = turned + STRIPER.bearings
    ranges = np.minimum(-x / np.cos(looks).clip(1e-6), (corner - y) / np.sin(looks))
    assert len(look_at_door((-0.7, 0.0, turned), STRIPER, ranges).wall) == 0
    askew = look_at_door((-0.7, 0.0, turned - 0.08), STRIPER, ranges)
    assert len(askew.wall) == 0


@pytest.mark.parametrize(("sonar", "metres"), [(0, 0.6), (4, 0.7), (-5, 0.7)])
def test_whoever_comes_near_beside_a_door_is_noticed_by_one_sonar(sonar, metres):
    heard = SILENT.copy()
    heard[sonar] = metres
    assert is_near((0.3, 0.0, 0.0), heard)
    assert not is_near((0.3, 0.0, 0.0), SILENT)


def test_jambs_and_the_wall_beside_a_door_are_nobody():
    heard = SILENT.copy()
    heard[1] = heard[-1] = 0.55
    assert not is_near((-0.85, 0.0, 0.0), heard)
