"""A robot that does not know where it is gets to its goal all the same."""

from __future__ import annotations

import math
from pathlib import Path
from typing import get_args

import pytest

from navigate.maps import Floor
from navigate.navigator import Navigator
from navigate.position import Picking, make_localizer
from xavier_sim.floors import load_floor
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

COTTAGE = str(Path(__file__).parents[1] / "xavier_sim" / "soak_floor.yaml")


@pytest.mark.parametrize("policy", get_args(Picking))
def test_it_finds_itself_on_the_way_by_each_policy(policy):
    plan = load_floor(COTTAGE)
    world, floor = World(plan, seed=1), Floor(plan)
    world.place_robot(5.4, 3.9, -math.pi / 2)
    robot = RobotState(world, SimClock(1.0e9), speed=None)
    localizer = make_localizer("pomdp", floor, policy=policy, start="anywhere")
    navigator = Navigator(floor, localizer=localizer)
    assert localizer.lost
    drive = navigator.start(floor.place("r-3"), robot.sensors())
    for _ in range(3000):
        wheels = navigator.step(robot.sensors())
        if drive.done:
            break
        world.step(wheels.speed, wheels.turn)
    truth = world.truth()
    assert drive.done
    assert drive.failure is None
    assert math.dist((truth.x, truth.y), floor.place("r-3")) < 0.3
