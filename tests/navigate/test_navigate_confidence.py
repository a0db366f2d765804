"""How sure the navigator is of a room, and what telling it does."""

from __future__ import annotations

import math

import pytest
from navigate_loop import Loop

from navigate.maps import Floor, load_plan
from navigate.position._confidence import ALIKE_DOUBT

PITCH = 3.597
"""Metres between the doors 5301 to 5315."""


def standing(room, seed=1):
    """A robot that looks west at a room's place, and a navigator that knows it."""
    x, y = Floor(load_plan()).place(room)
    return standing_at(x, y, math.pi, seed)


def standing_at(x, y, theta, seed=1):
    loop = Loop(seed=seed)
    loop.world.kidnap(x, y, theta)
    loop.navigator.localizer.place((x, y, theta))
    loop.rest(6)
    return loop


def test_a_room_among_like_ones_is_not_certain_until_somebody_says_so():
    loop = standing("r-5307")
    assert loop.navigator.position().confidence == pytest.approx(1.0 - ALIKE_DOUBT, abs=0.02)
    assert loop.navigator.set_position("r-5307").confidence > 0.97
    loop.rest(10)
    assert loop.navigator.position().confidence > 0.97


def test_a_room_unlike_its_neighbours_can_be_certain():
    assert standing("r-5331").navigator.position().confidence > 0.97


def test_belief_that_the_sonars_contradict_is_not_trusted():
    loop = standing("r-5331")
    loop.world.kidnap(7.57, 30.0, math.pi)
    loop.rest(60)
    assert loop.navigator.position().confidence < 0.8


def test_nowhere_in_particular_there_is_no_confidence():
    position = Loop(seed=1).navigator.position()
    assert (position.room, position.confidence) == (None, 0.0)


@pytest.mark.parametrize("spot", ["inside", "before the door"])
def test_a_navigator_that_is_told_where_it_is_goes_on_from_there(spot):
    loop = standing("r-5303")
    place = loop.world.plan.places["r-5309"]
    x = place.x if spot == "inside" else place.x + 1.9
    loop.world.kidnap(x, place.y, math.pi)
    loop.rest(6)
    assert loop.navigator.set_position("R-5309").room in {"r-5309", None}
    assert loop.astray() < 0.5
    assert loop.drive("r-5307").failure is None
    assert loop.world.truth().room == "r-5307"


def test_who_was_turned_round_finds_its_heading_again_when_told_the_room():
    loop = standing("r-5303")
    loop.world.kidnap(*loop.world.place_of("r-5309"), 0.5)
    loop.rest(6)
    loop.navigator.set_position("r-5309")
    turn = loop.navigator.position().theta - loop.world.truth().theta
    assert abs(math.remainder(turn, math.tau)) < 0.3


def test_one_door_too_far_for_slipping_wheels_and_right_after_being_told():
    """Haigh & Veloso (1998): the robot is found in r-5305 when it believed r-5303."""
    loop = standing_at(7.57, 18.0, math.pi / 2)
    drive = loop.start("r-5303")
    loop.world.robot.slip(-PITCH, 0.0)
    for _ in range(900):
        if drive.done:
            break
        loop.tick()
    assert drive.failure is None
    assert loop.navigator.position().room == "r-5303"
    assert loop.navigator.position().confidence <= 1.0 - ALIKE_DOUBT
    assert loop.world.truth().room == "r-5305"
    loop.navigator.set_position("r-5305")
    assert loop.drive("r-5303").failure is None
    assert loop.world.truth().room == "r-5303"
