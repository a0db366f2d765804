"""The base's reflex: no command drives the robot on into what it touches or hears ahead."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from xavier_sim.floors import load_floor
from xavier_sim.messages import BUMP_PANELS, SONAR_COUNT
from xavier_sim.robot import Reading
from xavier_sim.running import Reflex
from xavier_sim.running._reflex import RIM, needed, room_before
from xavier_sim.world import World

PLAN = load_floor()
ALL = (1 << SONAR_COUNT) - 1
RANGES = st.one_of(st.floats(0.2, 6.5), st.just(math.inf), st.just(math.nan))
SPEEDS = st.floats(-0.7, 0.7)


def reading(*, sonar=math.inf, fresh=ALL, speed=0.0, bump=0):
    ranges = np.broadcast_to(np.asarray(sonar, dtype=np.float32), SONAR_COUNT)
    odom, none = np.zeros(3, dtype=np.float32), np.empty(0, dtype=np.float32)
    return Reading(0, ranges, fresh, odom, speed, 0.0, bump, striper=none, lidar=none)


@given(
    st.lists(RANGES, min_size=SONAR_COUNT, max_size=SONAR_COUNT),
    st.integers(0, 255),
    SPEEDS,
    SPEEDS,
)
def test_a_command_goes_through_whole_or_the_wheels_stop(ranges, bump, speed, turn_rate):
    reflex = Reflex()
    reflex.sense(reading(sonar=ranges, bump=bump))
    allowed = reflex.allow(speed, turn_rate)
    assert allowed == ((0.0, 0.0) if reflex.holds else (speed, turn_rate))
    if allowed[0] > 0.0:
        assert needed(speed) <= reflex.room
        assert not bump & 0b10000011
    if allowed[0] < 0.0:
        assert not bump & 0b00111000


@given(st.integers(0, BUMP_PANELS - 1), st.floats(0.01, 0.7))
def test_off_a_contact_it_may_drive_and_turn(panel, speed):
    reflex = Reflex()
    reflex.sense(reading(bump=1 << panel))
    away = -speed if math.cos(math.tau * panel / BUMP_PANELS) > 0.0 else speed
    assert reflex.allow(away, 0.5) == (away, 0.5)
    assert reflex.allow(0.0, 0.5) == (0.0, 0.5)


@given(st.sampled_from([0, 1, 2, 22, 23]), st.floats(0.2, 6.0))
def test_the_room_before_an_echo_is_where_the_rim_meets_it(number, echo):
    room = room_before(number, echo)
    assume(0.0 < room < math.inf)
    angle, distance = math.tau * number / SONAR_COUNT, 0.25 + echo
    ahead, aside = distance * math.cos(angle), distance * math.sin(angle)
    assert math.hypot(ahead - room, aside) == pytest.approx(RIM)


def test_between_two_readings_the_way_driven_counts():
    reflex = Reflex()
    reflex.sense(reading(sonar=1.0))
    before = reflex.room
    for _ in range(3):
        reflex.sense(reading(sonar=5.0, fresh=0, speed=0.5))
    assert reflex.room == pytest.approx(before - 0.15)
    reflex.sense(reading(sonar=5.0))
    assert reflex.room > 4.0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("speed", [0.3, 0.5, 0.7])
def test_a_driver_that_sees_nothing_does_not_ram_a_door(seed, speed):
    """A door shuts before a robot that is told to drive on: it brakes, or stops at the touch."""
    world, reflex = World(PLAN, seed), Reflex()
    door = next(one for one in PLAN.doors if one.name == "d-5303").at
    place = PLAN.places["r-5303"]
    look = math.atan2(place.y - door.y, place.x - door.x)
    world.place_robot(door.x - 1.2 * math.cos(look), door.y - 1.2 * math.sin(look), look)
    world.set_door("d-5303", is_open=False)
    touched = 0
    for _ in range(60):
        before = world.reading
        now = world.step(*reflex.allow(speed, 0.0))
        reflex.sense(now)
        if now.bump and not before.bump:
            touched += 1
            assert before.speed < 0.25
        if before.bump:
            assert now.speed < 0.05
    assert touched <= 1
    assert world.reading.speed == pytest.approx(0.0, abs=0.01)
