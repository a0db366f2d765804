"""Send a robot that knows nothing of where it is to a room, by each of the policies.

    python bench/anywhere.py --drives 10 --seed 1

The robot stands at a random place of the floor with a random heading, the belief is even over
all states, and it is sent to a random room. It drives where its belief says, finds itself on the
way, and goes on by its route. Metres are beside those of the shortest way. Deterministic by seed.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import get_args

import numpy as np
from kidnapped import random_pose

from navigate.body import Pose
from navigate.maps import Floor, load_plan
from navigate.navigator import Navigator
from navigate.position import Picking, PomdpLocalizer
from navigate.routes import Planner
from xavier_sim.floors import load_floor
from xavier_sim.profile import PROFILES
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

MOST_TICKS = 9000
START = (18.0, 39.6, 0.0)
"""Where the estimate lies that means nothing."""

AT_ROOM = 0.5
"""Metres from a room's place within which the robot has arrived."""


@dataclass
class Outcome:
    """What became of the drives of one policy."""

    arrived: int = 0
    elsewhere: int = 0
    metres: list[float] = field(default_factory=list)
    shares: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)

    def row(self) -> dict[str, float | int]:
        """The figures under the names that are printed."""
        return {
            "arrived": self.arrived,
            "elsewhere": self.elsewhere,
            "mean_metres": round(float(np.mean(self.metres or [0.0])), 1),
            "by_shortest": round(float(np.mean(self.shares or [0.0])), 2),
            "mean_seconds": round(float(np.mean(self.seconds or [0.0])), 1),
        }


def drive(robot: RobotState, navigator: Navigator, room: str, outcome: Outcome) -> None:
    """From where the robot was put down to a room."""
    floor, world = navigator.floor, robot.world
    before = world.truth()
    goal = floor.place(room)
    course = navigator.start(goal, robot.sensors())
    for _ in range(MOST_TICKS):
        wheels = navigator.step(robot.sensors())
        if course.done:
            break
        world.step(wheels.speed, wheels.turn)
    navigator.cancel()
    truth = world.truth()
    if not course.done or course.failure is not None:
        return
    if math.dist((truth.x, truth.y), goal) > AT_ROOM:
        outcome.elsewhere += 1
        return
    outcome.arrived += 1
    metres = truth.metres - before.metres
    shortest = shortest_way(navigator.planner, (before.x, before.y), goal)
    outcome.metres.append(metres)
    outcome.shares.append(metres / max(shortest, 1.0))
    outcome.seconds.append((truth.tick - before.tick) * 0.1)


def shortest_way(planner: Planner, start: tuple[float, float], goal: tuple[float, float]) -> float:
    """Metres of the best way between two points."""
    points = [start, *(step.to for step in planner.plan(start, goal))]
    return sum(math.dist(one, other) for one, other in pairwise(points))


def run(drives: int, seed: int, policy: Picking, profile: str) -> Outcome:
    """So many drives by one policy; all policies have the same ones."""
    world = World(load_floor("wean5"), seed, PROFILES[profile])
    robot = RobotState(world, SimClock(0.0), speed=None)
    floor, true_floor = Floor(load_plan()), Floor(world.plan)
    localizer = PomdpLocalizer(floor, picking=policy)
    navigator = Navigator(floor, localizer=localizer)
    random, outcome = np.random.default_rng(seed), Outcome()
    rooms = sorted(floor.places)
    for _ in range(drives):
        pose: Pose = random_pose(world, true_floor, random)
        room = rooms[int(random.integers(len(rooms)))]
        world.place_robot(*pose)
        localizer.place(START)
        localizer.forget()
        drive(robot, navigator, room, outcome)
    return outcome


def main() -> None:
    """Parse the command line and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--profile", choices=sorted(PROFILES), default="xavier")
    parser.add_argument("--policies", nargs="*", choices=get_args(Picking))
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    for policy in options.policies or get_args(Picking):
        outcome = run(options.drives, options.seed, policy, options.profile)
        row = {"policy": policy, **outcome.row()}
        print(json.dumps(row) if options.json else row, flush=True)


if __name__ == "__main__":
    main()
