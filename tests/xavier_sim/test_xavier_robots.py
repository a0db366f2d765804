"""Several robots on one floor: each with senses of its own, and in each other's way."""

from __future__ import annotations

import hashlib
import json
import math
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from xavier_sim.floors import load_floor
from xavier_sim.profile import XAVIER
from xavier_sim.world import NotFreeError, RobotsError, World

PLAN = load_floor()
NAMES = ("xavier", "yoda", "rogue")
WIDTH = 2 * XAVIER.base.radius


def crowded(seed, names=NAMES):
    """Robots side by side in a corner of the foyer, where they must run into each other."""
    world = World(PLAN, seed=seed, robots=names)
    for number, name in enumerate(names):
        world.place_robot(4.6 + 0.9 * number, 9.1, 0.3, robot=name)
    return world


def mill(world, ticks, seed):
    """Drive all about at random; hash what they sense."""
    choose, digest = random.Random(seed), hashlib.sha256()
    commands = {}
    for number in range(ticks):
        if number % 12 == 0:
            drive = {
                name: (choose.uniform(-0.4, 0.8), choose.uniform(-1.2, 1.2))
                for name in world.robots
            }
            commands = drive
        for reading in world.step_all(commands).values():
            fields = (reading.sonar_fresh, reading.bump, reading.speed, reading.turn_rate)
            digest.update(reading.sonar.tobytes() + reading.odom.tobytes())
            digest.update(repr(fields).encode())
    return digest.hexdigest()


def apart(world):
    at = [(truth.x, truth.y) for truth in map(world.truth, world.robots)]
    return min(math.dist(one, other) for i, one in enumerate(at) for other in at[:i])


def test_robots_start_apart_and_free():
    world = World(PLAN, robots=[f"robot-{number}" for number in range(6)])
    assert apart(world) > WIDTH + 0.2
    assert not any(reading.bump for reading in world.step_all({}).values())


def test_first_robot_senses_the_same_noise_whether_alone_or_not():
    alone, together = World(PLAN, seed=3), World(PLAN, seed=3, robots=NAMES)
    for name in NAMES[1:]:
        together.place_robot(*together.place_of("r-5411"), 0.0, robot=name)
        together.place_robot(*together.place_of("r-5415"), 0.0, robot="rogue")
    for _ in range(4):  # until the whole ring has forgotten that the others stood there
        alone.step(0.4, 0.1), together.step(0.4, 0.1)
    for _ in range(50):
        one, other = alone.step(0.4, 0.1), together.step(0.4, 0.1)
        assert np.array_equal(one.sonar, other.sonar)
        assert np.array_equal(one.odom, other.odom)


def test_robots_do_not_share_noise():
    world = World(PLAN, seed=3, robots=("xavier", "yoda"))
    for name in world.robots:
        world.place_robot(7.57, 21.4 if name == "xavier" else 24.997, 0.0, robot=name)
    readings = world.step_all({})
    assert not np.array_equal(readings["xavier"].sonar, readings["yoda"].sonar)


@settings(max_examples=4, deadline=None)
@given(st.integers(0, 1000))
def test_robots_never_stand_in_each_other(seed):
    world = crowded(seed)
    for number in range(25):
        mill(world, 8, seed + number)
        assert apart(world) > WIDTH - 0.03
        assert all(world.truth(name).space for name in NAMES)


@settings(max_examples=5, deadline=None)
@given(st.integers(0, 200), st.integers(0, 1000))
def test_restored_world_of_robots_goes_on_bit_for_bit(ticks, seed):
    straight, resumed = crowded(seed), World(PLAN, seed=0, robots=NAMES)
    mill(straight, ticks, seed)
    resumed.restore(json.loads(json.dumps(straight.snapshot())))
    assert mill(resumed, 120, seed + 1) == mill(straight, 120, seed + 1)
    assert [resumed.truth(name) for name in NAMES] == [straight.truth(name) for name in NAMES]


def test_robots_bump_into_each_other():
    world = World(PLAN, seed=1, robots=("xavier", "yoda"))
    world.place_robot(7.57, 20.0, math.pi / 2)
    world.place_robot(7.57, 22.0, -math.pi / 2, robot="yoda")
    bumps = [
        {name: reading.bump for name, reading in world.step_all(both_ahead()).items()}
        for _ in range(60)
    ]
    assert {"xavier": 1, "yoda": 1} in bumps
    assert world.truth().bumps == world.truth("yoda").bumps == 1
    assert apart(world) == pytest.approx(WIDTH, abs=0.02)


def both_ahead():
    return {"xavier": (0.3, 0.0), "yoda": (0.3, 0.0)}


def test_one_without_a_command_stops():
    world = World(PLAN, robots=("xavier", "yoda"))
    for _ in range(20):
        world.step_all({"yoda": (0.5, 0.0)})
    assert world.truth().metres == 0.0
    assert world.truth("yoda").metres > 0.3


def test_robot_is_not_put_upon_another():
    world = World(PLAN, robots=("xavier", "yoda"))
    at = world.truth("yoda")
    with pytest.raises(NotFreeError, match="yoda stands there"):
        world.kidnap(at.x + 0.3, at.y)
    world.kidnap(at.x + 0.3, at.y, robot="yoda")


@pytest.mark.parametrize("names", [(), ("xavier", "xavier")])
def test_names_must_be_told_apart(names):
    with pytest.raises(RobotsError, match="one name or more, each once"):
        World(PLAN, robots=names)


def test_snapshot_of_other_robots_is_refused():
    with pytest.raises(RobotsError, match="xavier, as in the snapshot"):
        World(PLAN, robots=("xavier", "yoda")).restore(World(PLAN).snapshot())
