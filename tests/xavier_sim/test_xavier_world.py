"""The world as a pure function: what drives, what stops it, what it senses, and the same again."""

from __future__ import annotations

import hashlib
import json
import math
import random
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from xavier_sim.floors import UnknownDoorError, load_floor
from xavier_sim.world import World

PLAN = load_floor()


@pytest.fixture
def world():
    return World(PLAN, seed=1)


def stroll(world, ticks, seed):
    """Drive about at random, into walls too, as doors move; hash what it senses."""
    choose, digest = random.Random(seed), hashlib.sha256()
    command = (0.0, 0.0)
    for number in range(ticks):
        if number % 15 == 0:
            command = (choose.uniform(-0.3, 0.8), choose.uniform(-1.2, 1.2))
        if number % 40 == 0:
            world.set_door(choose.choice(PLAN.doors).name, is_open=choose.random() < 0.5)
        reading = world.step(*command)
        digest.update(reading.sonar.tobytes() + reading.odom.tobytes())
        fields = (reading.sonar_fresh, reading.bump, reading.speed, reading.turn_rate)
        digest.update(repr(fields).encode())
    return digest.hexdigest()


def drive(world, ticks, speed=0.5, turn_rate=0.0):
    return [world.step(speed, turn_rate) for _ in range(ticks)]


def test_same_commands_same_readings():
    logs = {stroll(World(PLAN, seed=5), 800, 3) for _ in range(2)}
    assert len(logs) == 1
    assert stroll(World(PLAN, seed=6), 800, 3) not in logs


CHILD = """
import sys
sys.path.insert(0, {here!r})
from test_xavier_world import PLAN, World, stroll
print(stroll(World(PLAN, seed=5), 800, 3))
"""


def test_same_readings_in_another_process():
    code = CHILD.format(here=str(__file__).rsplit("/", 1)[0])
    environment = {"PYTHONHASHSEED": "7", "PATH": ""}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == stroll(World(PLAN, seed=5), 800, 3)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 300), st.integers(0, 1000))
def test_restored_world_goes_on_bit_for_bit(ticks, seed):
    straight = World(PLAN, seed=seed)
    # Beside a corner of the foyer there is much to run into.
    straight.place_robot(4.6, 9.1, 0.3)
    stroll(straight, ticks, seed)
    resumed = World(PLAN, seed=0)
    resumed.restore(json.loads(json.dumps(straight.snapshot())))
    assert stroll(resumed, 200, seed + 1) == stroll(straight, 200, seed + 1)
    assert resumed.truth() == straight.truth()
    assert resumed.snapshot() == {**straight.snapshot(), "seed": resumed.seed}


def test_snapshot_in_the_middle_of_a_contact(world):
    world.place_robot(7.57, 21.4, 2.6)
    drive(world, 25)
    assert world.reading.bump
    resumed = World(PLAN, seed=9)
    resumed.restore(world.snapshot())
    assert stroll(resumed, 200, 4) == stroll(world, 200, 4)


def test_speed_is_limited_and_takes_time(world):
    speeds = [reading.speed for reading in drive(world, 30, speed=2.0)]
    assert speeds[0] == pytest.approx(0.07)
    assert speeds[-1] == pytest.approx(0.7)
    assert all(reading.turn_rate <= 1.5 for reading in drive(world, 30, 0.0, 4.0))


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
def test_absurd_command_is_a_stop(world, wrong):
    drive(world, 5)
    assert drive(world, 20, speed=wrong, turn_rate=wrong)[-1].speed == 0.0


def test_turns_in_place(world):
    drive(world, 30, speed=0.0, turn_rate=1.0)
    truth = world.truth()
    assert (truth.x, truth.y) == (PLAN.start.x, PLAN.start.y)
    assert truth.metres == 0.0
    assert truth.theta == pytest.approx(-1.8626, abs=0.3)


def test_wall_stops_the_robot_and_presses_the_front_panel(world):
    world.place_robot(7.57, 21.4, math.pi)
    readings = drive(world, 60)
    assert world.truth().x == pytest.approx(6.37 + 0.305 + 0.02, abs=0.005)
    assert readings[-1].bump == 1
    assert readings[-1].speed == pytest.approx(0.0, abs=0.02)


def test_one_push_is_one_bump(world):
    world.place_robot(7.57, 21.4, math.pi)
    drive(world, 60)
    assert world.truth().bumps == 1
    drive(world, 20, speed=-0.3)
    drive(world, 40)
    assert world.truth().bumps == 2


def test_bump_behind_presses_the_rear_panel(world):
    world.place_robot(7.57, 21.4, 0.0)
    assert drive(world, 60, speed=-0.5)[-1].bump == 1 << 4


def test_open_door_lets_pass_and_closed_one_does_not(world):
    world.place_robot(7.57, 23.165, math.pi)
    drive(world, 45)
    assert world.truth().space == "r-5303"
    assert world.truth().bumps == 0
    world.set_door("r-5303", is_open=False)
    world.place_robot(7.57, 23.165, math.pi)
    drive(world, 45)
    assert world.truth().space == "corridor-53"
    assert world.truth().room == "r-5303"


def test_door_does_not_shut_on_the_robot(world):
    world.place_robot(6.37, 23.165, math.pi)
    assert world.set_door("r-5303", is_open=False) == ("d-5303", "r-5303", True)
    assert world.doors()["r-5303"]


def test_unknown_door_names_near_matches(world):
    with pytest.raises(UnknownDoorError, match="Did you mean 'r-5303'"):
        world.set_door("r5303", is_open=True)


def test_every_place_is_inside_its_room_and_clear_of_walls():
    world = World(PLAN)
    for room, place in PLAN.places.items():
        world.place_robot(place.x, place.y, 0.0)
        world.step(0.0, 0.0)
        assert world.truth().room == room
        assert world.reading.bump == 0


def test_a_quarter_of_the_ring_is_fresh_each_tick(world):
    assert world.reading.sonar_fresh == (1 << 24) - 1
    bits = [reading.sonar_fresh for reading in drive(world, 4)]
    assert [part.bit_count() for part in bits] == [6, 6, 6, 6]
    assert bits[0] | bits[1] | bits[2] | bits[3] == (1 << 24) - 1


def test_stale_sonars_keep_their_reading(world):
    before = world.reading.sonar
    reading = world.step(0.0, 0.0)
    stale = [i for i in range(24) if not reading.sonar_fresh >> i & 1]
    assert np.array_equal(reading.sonar[stale], before[stale])


def test_sonar_is_noisy_but_about_right(world):
    world.place_robot(7.57, 21.4, 0.0)
    ahead = np.array([reading.sonar[0] for reading in drive(world, 800, speed=0.0)[::4]])
    near = np.abs(ahead - 0.95) < 0.15
    assert near.mean() > 0.95
    assert ahead[near].mean() == pytest.approx(0.95, abs=0.02)
    assert 0.01 < ahead[near].std() < 0.05


def test_sonar_along_a_corridor_wall_glances_off(world):
    """15 degrees off the corridor's axis some rays of the cone are lost, now these, now those."""
    world.place_robot(7.57, 21.4, math.pi / 2)
    readings = [reading.sonar for reading in drive(world, 400, speed=0.0)]
    slanting = np.array([sonar[1] for sonar in readings[0::4]])
    straight = np.array([sonar[6] for sonar in readings[1::4]])
    assert spread(slanting) > 5 * spread(straight)


def spread(readings):
    """Distance between the 5th and the 90th percentile: outliers do not count."""
    low, high = np.quantile(np.minimum(readings, 6.5), [0.05, 0.9])
    return high - low


def test_odometry_drifts_by_some_percent():
    errors = []
    for seed in range(8):
        world = World(PLAN, seed=seed)
        drive(world, 600)
        truth, odom = world.truth(), world.reading.odom
        errors.append(math.hypot(odom[0] - truth.metres, odom[1]))
        assert world.truth().bumps == 0
    assert 0.1 < np.median(errors) < 4.0
    assert min(errors) > 0.0


def test_odometry_jumps_at_a_bump(world):
    world.place_robot(7.57, 21.4, math.pi)
    poses = [reading.odom for reading in drive(world, 60)]
    sideways = np.abs(np.diff([pose[1] for pose in poses]))
    assert sideways.max() > 5 * np.median(sideways)


def test_robot_stays_on_the_floor():
    world = World(PLAN, seed=2)
    for ticks in range(10):
        stroll(world, 300, ticks)
        assert world.truth().space is not None
