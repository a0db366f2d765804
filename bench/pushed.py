"""Set the robot askew into doors, and see how it gets through.

    python bench/pushed.py --degrees 10 --aside 0.15 --profile hard

At each door of the floor it is put 0.3 m before the line, to the left and to the right of the
middle, and turned as if a wheel had slipped there: where it stands it knows, but not that it looks
half the degrees to one side of the axis, for it believes to look as much to the other. It is sent
into the room; each contact on the way counts as a touch. Nobody is about. Deterministic by seed.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import get_args

import numpy as np

from navigate.maps import Floor, Passage
from navigate.navigator import Navigator
from navigate.routes import side_of
from xavier_sim.floors import load_floor, survey_floor
from xavier_sim.messages import ProfileName
from xavier_sim.profile import PROFILES, TICK
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

BEFORE = 0.3
"""Metres before the line of the door at which the robot is put."""

SURVEY_SIGMA = 0.03
"""Metres by which walls and doors of its map err, as in a soak."""

NEAR = 0.5
"""Metres from the place of the room within which an arrival is one."""

MOST_TICKS = 2000


@dataclass(frozen=True)
class Push:
    """How the robot is set askew: metres to the left of the middle, and radians to the left."""

    aside: float
    turned: float


@dataclass(frozen=True)
class Outcome:
    """How one drive ended, after so many simulated seconds."""

    door: str
    arrived: bool
    touches: int
    seconds: float


def push_into(door: Passage, push: Push, seed: int, profile: ProfileName) -> Outcome:
    """Set the robot askew into a door and send it into the room behind."""
    world = World(load_floor("wean5"), seed, PROFILES[profile])
    robot = RobotState(world, SimClock(0.0), speed=None)
    floor = Floor(survey_floor(world.plan, sigma=SURVEY_SIGMA, seed=seed))
    navigator = Navigator(floor, seed=seed)
    room = next(space for space in door.spaces if space in floor.places)
    x, y, ahead = before(door, floor.place(room), push.aside)
    world.place_robot(x, y, ahead + push.turned / 2)
    navigator.step(robot.sensors())
    navigator.localizer.place((x, y, ahead - push.turned / 2), spread=0.05, turn_spread=0.04)
    return drive_into(room, door.name, navigator, robot)


def before(door: Passage, inside: tuple[float, float], aside: float) -> tuple[float, float, float]:
    """Where the robot is put: so far aside of the middle, looking along the axis."""
    sign = side_of(door, inside)
    ahead = math.atan2(sign * door.normal[1], sign * door.normal[0])
    x = door.centre[0] - BEFORE * math.cos(ahead) - aside * math.sin(ahead)
    y = door.centre[1] - BEFORE * math.sin(ahead) + aside * math.cos(ahead)
    return x, y, ahead


def drive_into(room: str, door: str, navigator: Navigator, robot: RobotState) -> Outcome:
    """Drive until it is over, and judge that by the truth."""
    world = robot.world
    drive = navigator.start(navigator.floor.place(room), robot.sensors())
    begun, bumps = world.tick, world.truth().bumps
    while not drive.done and world.tick - begun < MOST_TICKS:
        world.step(navigator.wheels.speed, navigator.wheels.turn)
        navigator.step(robot.sensors())
    truth = world.truth()
    near = math.dist((truth.x, truth.y), world.place_of(room)) < NEAR
    arrived = drive.done and drive.failure is None and near
    return Outcome(door, arrived, truth.bumps - bumps, (world.tick - begun) * TICK)


def pushes(degrees: float, aside: float) -> Iterator[Push]:
    """To either side, and turned to either side there."""
    for side in (-1.0, 1.0):
        for turn in (-1.0, 1.0):
            yield Push(side * aside, turn * math.radians(degrees))


def row_of(outcomes: list[Outcome]) -> dict[str, float | int]:
    """The figures under the names that are printed."""
    touches = [one.touches for one in outcomes]
    return {
        "drives": len(outcomes),
        "arrived": sum(one.arrived for one in outcomes),
        "touches": sum(touches),
        "drives_with_more_than_two": sum(number > 2 for number in touches),
        "most_touches": max(touches, default=0),
        "mean_seconds": round(float(np.mean([one.seconds for one in outcomes])), 1),
    }


def main() -> None:
    """Parse the command line and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--degrees", type=float, default=10.0)
    parser.add_argument("--aside", type=float, default=0.15)
    parser.add_argument("--every", type=int, default=1, help="only each n-th door")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--profile", choices=get_args(ProfileName), default="hard")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    doors = list(Floor(load_floor("wean5")).doors.values())[:: options.every]
    outcomes = [
        push_into(door, push, options.seed + number, options.profile)
        for number, door in enumerate(doors)
        for push in pushes(options.degrees, options.aside)
    ]
    row = {"degrees": options.degrees, "aside": options.aside, **row_of(outcomes)}
    lines = [f"{name:26} {value}" for name, value in row.items()]
    print(json.dumps(row) if options.json else "\n".join(lines))


if __name__ == "__main__":
    main()
