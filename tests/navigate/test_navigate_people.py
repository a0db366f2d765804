"""People in the way: waited for, then passed, and never run into."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from corridor import Corridor, standing
from hypothesis import given, settings
from hypothesis import strategies as st

from navigate.body import RING_RADIUS, ROBOT_RADIUS, STRIPER
from navigate.driving import Strangers, View
from navigate.driving._courtesy import (
    CREEP_SPEED,
    KEEP_OFF,
    PASSING_SPEED,
    STALE,
    WAIT_SECONDS,
    Courtesy,
    approach_speed,
)
from navigate.driving._follow import MOUTH_SPEED, way_through
from navigate.driving._follow import _past_mouths as past_mouths
from navigate.driving._strangers import Stranger, strange_sights
from navigate.driving._view import WayBlocked
from navigate.freezing import freeze, thaw
from xavier_sim.messages import Corner, Space, SpaceKind

GENTLE = 0.1
"""Metres per second at which the robot may touch somebody."""


def test_an_empty_corridor_is_driven_at_full_speed():
    hall = Corridor()
    assert hall.drive() is None
    assert hall.courtesy.waited == 0.0
    assert hall.time < 15.0 / 0.6 + 4.0


def test_who_stands_in_the_way_is_waited_for_then_passed():
    hall = Corridor(standing(7.0, 0.1))
    assert hall.drive() is None
    assert hall.courtesy.waited == pytest.approx(WAIT_SECONDS, abs=1.0)
    assert hall.touched is None
    assert hall.nearest > 0.03


@pytest.mark.parametrize(("aside", "speed"), [(1.05, PASSING_SPEED), (0.95, CREEP_SPEED)])
def test_who_stands_aside_is_passed_slowly_without_a_wait(aside, speed):
    hall = Corridor(standing(7.0, aside))
    assert hall.drive() is None
    assert hall.courtesy.waited == 0.0
    assert hall.touched is None
    beside = [now for now, x in zip(hall.speeds, hall.driven(), strict=True) if 6.0 < x < 8.0]
    assert min(beside) == pytest.approx(speed, abs=0.07)


@pytest.mark.parametrize(
    ("aside", "speed"), [(0.65, CREEP_SPEED), (0.9, PASSING_SPEED), (1.2, 0.6)]
)
def test_whoever_stands_right_beside_the_robot_is_crept_past_however_long_they_stood(aside, speed):
    """They may set out into its side before a sonar tells."""
    strangers, view = Strangers(), seen(100.0)
    at = (0.3, aside)
    strangers.around = [Stranger(at, 100.0, since=40.0, stood=at, eye=(0.0, 0.0), heard=50)]
    assert Courtesy(strangers).speed(view, 0.0, 0.6) == speed


def test_who_walks_towards_the_robot_and_round_it_meets_one_that_stands():
    def walk(time):
        x = 14.0 - 1.2 * time
        aside = 0.85 if abs(x - 5.0) < 3.0 else 0.0
        return x, aside

    hall = Corridor(walk)
    assert hall.drive() is None
    assert (hall.touched or 0.0) <= GENTLE


def test_who_walks_straight_into_the_robot_is_not_pushed():
    hall = Corridor(lambda time: (max(4.0, 14.0 - 1.2 * time), 0.0))
    hall.drive()
    assert (hall.touched or 0.0) <= GENTLE


def test_who_walks_ahead_is_followed_and_not_overtaken_at_speed():
    hall = Corridor(lambda time: (2.0 + 0.3 * time, 0.0))
    hall.drive(seconds=200.0)
    assert hall.touched is None


def test_who_crosses_the_corridor_is_let_pass():
    hall = Corridor(lambda time: (6.0, 1.6 - 0.5 * max(0.0, time - 7.0)))
    assert hall.drive() is None
    assert (hall.touched or 0.0) <= GENTLE


def test_a_crowd_that_fills_the_corridor_blocks_it():
    hall = Corridor(*[standing(6.0, y) for y in (-0.8, 0.0, 0.8)])
    trouble = hall.drive()
    assert isinstance(trouble, WayBlocked)
    assert trouble.at[0] == pytest.approx(6.0, abs=1.0)
    assert hall.touched is None


@settings(deadline=None, max_examples=8)
@given(st.floats(3.0, 9.0), st.floats(-0.7, 0.7), st.floats(0.0, 1.3))
def test_nobody_is_touched_at_speed(x, y, pace):
    hall = Corridor(lambda time: (max(x - 2.0, x + 6.0 - pace * time), y))
    hall.drive(metres=10.0, seconds=200.0)
    assert (hall.touched or 0.0) <= GENTLE


@given(st.floats(0.0, 5.0), st.floats(0.0, 2.0))
def test_the_speed_leaves_room_to_stop_for_who_comes(room, walking):
    speed = approach_speed(room, walking)
    used = speed * STALE + speed**2 / 2.0 + walking * (STALE + speed)
    if speed > 0.0:
        assert used == pytest.approx(room)
    else:
        assert walking * STALE >= room - 1e-9
    assert KEEP_OFF > 0.0


def test_whoever_walks_up_from_aside_is_slowed_for_before_they_are_near():
    hall = Corridor(lambda time: (6.0, 1.0 - 0.3 * max(0.0, time - 5.0)))
    hall.drive()
    assert (hall.touched or 0.0) <= GENTLE


@pytest.mark.parametrize(("turned", "minded"), [(-0.65, True), (0.65, False)])
def test_whoever_is_beside_a_robot_that_turns_is_minded_though_its_way_leads_off(turned, minded):
    """Behind as the way goes, but before the right side of a robot that looks to its right."""
    hall = Corridor(standing(4.6, -0.6))
    hall.pose = (5.0, 0.0, turned)
    hall.drive()
    soon = hall.speeds[2:8]
    assert (max(soon) <= GENTLE) is minded


def test_strangers_are_met_in_the_space_that_the_robot_comes_from():
    here = Space(name="c", kind=SpaceKind.CORRIDOR, low=Corner(x=0, y=0), high=Corner(x=2, y=9))
    there = Space(name="d", kind=SpaceKind.CORRIDOR, low=Corner(x=-9, y=9), high=Corner(x=9, y=11))
    far = Space(name="e", kind=SpaceKind.CORRIDOR, low=Corner(x=9, y=9), high=Corner(x=19, y=11))
    way = way_through(there, (1.0, 6.0), (8.0, 10.0), beside=(here, there, far))
    assert way.around((1.0, 8.0)) == [there, here]
    assert way.around((1.0, 13.0)) == [there]
    assert way.around((7.0, 10.0)) == [there, far]


def test_past_a_door_right_beside_it_the_robot_slows_down():
    hall = Corridor()
    doors = [((4.55, 1.2), (5.45, 1.2)), ((8.55, -1.2), (9.45, -1.2)), ((12.0, -0.6), (12.0, 1.8))]
    way = way_through(hall.space, (0.0, 0.6), (15.0, 0.6), doors)
    assert past_mouths(way, 4.5, 0.0, 0.6) == MOUTH_SPEED
    assert past_mouths(way, 4.5, -0.4, 0.6) == 0.6
    assert past_mouths(way, 8.5, 0.0, 0.6) == 0.6
    assert past_mouths(way, 7.0, 0.0, 0.6) == 0.6
    assert past_mouths(way, 11.5, 0.0, 0.6) == 0.6


HALL = Space(name="h", kind=SpaceKind.CORRIDOR, low=Corner(x=-5, y=-1.2), high=Corner(x=9, y=1.2))


def seen(time, *people, at=0.0):
    """What a robot at ``at`` in `HALL` sees by its light striper of people ahead, and hears not."""
    beams = [
        min((reach(person, at + STRIPER.ahead, look) for person in people), default=9.0)
        for look in STRIPER.bearings
    ]
    sight = STRIPER.look(np.array(beams, np.float32))
    pose, silence, nothing = (at, 0.0, 0.0), np.full(24, np.inf), np.empty((0, 2))
    return View(time, pose, pose, silence, 0, 0, nothing, sights=((STRIPER, sight),))


def reach(person, x, look):
    """Metres along a beam to somebody, beyond what is seen where it misses them."""
    ahead, left = person[0] - x, person[1]
    along, off = ahead * math.cos(look) + left * math.sin(look), ahead * math.sin(look)
    off -= left * math.cos(look)
    return along - math.sqrt(0.25**2 - off**2) if abs(off) < 0.25 else 9.0


def test_who_is_seen_twice_is_certain_though_no_sonar_hears_them():
    strangers = Strangers()
    strangers.listen(seen(0.0, (2.2, 0.1)), [HALL])
    assert [one.certain for one in strangers.around] == [False]
    strangers.listen(seen(0.1, (2.2, 0.1)), [HALL])
    assert [one.certain for one in strangers.around] == [True]
    assert strangers.around[0].at == pytest.approx((1.95, 0.1), abs=0.03)


def test_two_people_who_are_seen_are_two_strangers():
    assert len(strange_sights(seen(0.0, (2.9, -0.45), (2.5, 0.45)), [HALL])) == 2


def test_what_light_sees_at_a_wall_or_in_one_beam_is_nobody():
    assert strange_sights(seen(0.0, (2.9, -1.3)), [HALL]) == []
    assert strange_sights(seen(0.0, (2.9, 0.0)), []) == []
    assert strange_sights(seen(0.0), [HALL]) == []
    view = seen(0.0, (2.9, 0.0))
    (laser, sight), lone = view.sights[0], np.zeros(31, np.float32)
    lone[15:17] = sight.ranges[15:17]
    assert strange_sights(replace(view, sights=((laser, laser.look(lone)),)), [HALL]) == []


def test_who_is_seen_to_walk_slowly_does_not_stand():
    coming, standing = Strangers(), Strangers()
    for tick in range(40):
        coming.listen(seen(0.1 * tick, (2.9 - 0.03 * tick, 0.0)), [HALL])
        standing.listen(seen(0.1 * tick, (2.5, 0.0)), [HALL])
    assert not coming.around[0].stands(3.9)
    assert standing.around[0].stands(3.9)


def test_the_robot_slows_down_for_who_is_seen_to_come():
    manners = Manners()
    for tick in range(3):
        speed = manners.speed(seen(0.1 * tick, (2.0 - 0.13 * tick, 0.1)))
    assert 0.0 < speed < 0.35


class Manners:
    """Courtesy to those whom a robot that drives along `HALL` meets."""

    def __init__(self):
        self.strangers = Strangers()
        self.courtesy = Courtesy(self.strangers)

    def speed(self, view, *, wary=False):
        self.strangers.listen(view, [HALL])
        return self.courtesy.speed(view, 0.0, 0.65, wary=wary)


def heard_once(time, away, *, fresh=1 << 2):
    """What a robot in `HALL` hears of somebody 30 degrees to its left, by one sonar."""
    ranges = np.full(24, np.inf)
    ranges[2] = away - RING_RADIUS
    return replace(seen(time), ranges=ranges, fresh=fresh)


def test_near_a_corner_one_echo_is_enough_to_slow_down_for():
    assert Manners().speed(heard_once(0.0, 1.3)) == 0.65
    manners, speeds = Manners(), []
    for tick in range(8):
        view = heard_once(0.1 * tick, 1.3, fresh=1 << 2 if tick == 0 else 0)
        speeds.append(manners.speed(view, wary=True))
    assert speeds[0] == pytest.approx(approach_speed(1.3 - ROBOT_RADIUS - KEEP_OFF))
    assert speeds[:5] == [speeds[0]] * 5
    assert speeds[7] < speeds[0]  # who is not heard again has come nearer


def test_corners_are_the_ends_of_open_borders_near_the_robot():
    way = way_through(HALL, (0.0, 0.0), (8.0, 0.0), openings=[((5.0, 1.2), (7.0, 1.2))])
    assert way.corners == (5.0, 7.0)
    assert [way.has_corner_near(along) for along in (2.0, 3.0, 6.0, 7.4, 7.6)] == [
        False, True, True, True, False,
    ]  # fmt: skip
    assert not way_through(HALL, (0.0, 0.0), (8.0, 0.0)).has_corner_near(6.0)


def ring(*people, at=3.0):
    """The view of a robot at ``at`` in `HALL` that hears its walls, and people before them."""
    hall = Corridor(*[standing(*person) for person in people])
    hall.pose = (at, 0.0, 0.0)
    ranges = np.array([hall._sonar(number) for number in range(24)])
    return replace(seen(0.0, at=at), ranges=ranges, fresh=2**24 - 1)


def company(view, *, times=2):
    strangers = Strangers()
    for tick in range(times):
        strangers.listen(replace(view, time=0.1 * tick), [HALL])
    return strangers


def explained(strangers, view, *spaces):
    """Which sonars hear strangers."""
    bits = strangers.explained(view.ranges, view.pose, spaces or (HALL,))
    return np.array([bool(bits >> number & 1) for number in range(24)])


def test_strangers_explain_what_is_heard_of_them_and_no_more():
    alone, beset = ring(), ring((4.0, 0.3), (3.2, -0.75))
    theirs = explained(company(beset), beset)
    assert 4 <= theirs.sum() <= 10
    assert (beset.ranges < alone.ranges - 0.3)[theirs].all()
    assert not explained(company(alone), alone).any()


def test_strangers_explain_what_is_heard_beyond_an_open_border():
    near = Space(
        name="n", kind=SpaceKind.CORRIDOR, low=Corner(x=-5, y=-1.2), high=Corner(x=3.7, y=1.2)
    )
    beyond = Space(
        name="b", kind=SpaceKind.CORRIDOR, low=Corner(x=3.7, y=-9), high=Corner(x=9, y=9)
    )
    beset, strangers = ring((4.5, 0.0)), Strangers()
    for tick in range(2):
        strangers.listen(replace(beset, time=0.1 * tick), [near, beyond])
    assert not explained(strangers, beset, near).any()
    assert explained(strangers, beset, near, beyond).any()


def test_who_was_met_once_explains_nothing():
    beset, strangers = ring((4.0, 0.2)), Strangers()
    for tick, sure in enumerate((False, True)):
        strangers.listen(seen(0.1 * tick, (4.0, 0.2), at=3.0), [HALL])
        assert explained(strangers, beset).any() == sure


@pytest.mark.parametrize("half", [1.7, 4.0])
def test_walls_where_none_should_be_are_no_crowd(half):
    """A robot in a corridor that believes to be in a wider one, or in a lounge."""
    narrow, strangers = ring(), Strangers()
    wide = Space(
        name="l", kind=SpaceKind.CORRIDOR, low=Corner(x=-5, y=-half), high=Corner(x=9, y=half)
    )
    for tick in range(3):
        strangers.listen(replace(narrow, time=0.1 * tick), [wide])
    assert len(strangers.around) > 3
    assert not explained(strangers, narrow, wide).any()


def test_strangers_are_forgotten_soon_and_at_a_word():
    beset = ring((4.0, 0.3))
    strangers = company(beset)
    assert strangers.around
    strangers.listen(seen(1.4), [HALL])
    assert not strangers.around
    strangers = company(beset)
    strangers.listen(seen(-5.0), [HALL])  # the clock was set back
    assert not strangers.around
    strangers = company(beset)
    strangers.forget()
    assert not strangers.around


def test_strangers_go_on_where_they_were_frozen():
    strangers, thawed = company(ring((4.0, 0.3), (3.2, -0.75))), Strangers()
    thaw(thawed, json.loads(json.dumps(freeze(strangers))))
    assert thawed.around == strangers.around
    assert len(thawed.around) > 1
