"""Put the robot down somewhere else, untold, and see how soon it knows where it is.

    python bench/kidnapped.py --places 50 --seed 0 --localizer pomdp --profile hard

The robot stands where it believes to be; then it is put down at a random place of the floor, with
a random heading, and is led about by a guide who knows the way, from room to room, standing still
for two seconds every two metres. Its own navigator only listens, and is asked where it is. It
*knows* when the answer has been right, within 0.5 m and 30 degrees, and not called lost, for the
last three metres. Deterministic by seed.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass
from typing import get_args

import numpy as np

from navigate.body import Pose, wrap
from navigate.driving import STOP, Drive, Wheels
from navigate.maps import Floor, load_plan
from navigate.messages import LocalizerName
from navigate.navigator import Navigator
from navigate.position import DeadReckoning, Estimate, make_localizer
from xavier_sim.floors import load_floor
from xavier_sim.messages import ProfileName
from xavier_sim.profile import PROFILES
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

NEAR, TURNED = 0.5, math.radians(30.0)
"""How far off, in metres and radians, an answer is right."""

SURE = 3.0
"""Metres for which it must stay right."""

MOST_METRES = 80.0
MOST_TICKS = 6000
LISTEN_EVERY = 2.0
"""Metres after which the robot stands a while to listen."""

LISTEN_TICKS = 20


class Known(DeadReckoning):
    """The truth, for the guide."""

    def __init__(self, floor: Floor, world: World) -> None:
        self._world = world
        super().__init__(floor)

    @property
    def estimate(self) -> Estimate:
        truth = self._world.truth()
        return Estimate(truth.x, truth.y, truth.theta, 0.01, 0.01, 1.0)


class Guide:
    """Leads the robot from room to room, and lets it stand now and then."""

    def __init__(self, robot: RobotState, random: np.random.Generator) -> None:
        world, floor = robot.world, Floor(robot.world.plan)
        self._robot, self._world, self._random = robot, world, random
        self._navigator = Navigator(floor, localizer=Known(floor, world))
        self._rooms = sorted(world.plan.places)
        self._drive: Drive | None = None
        self._listening, self._since = LISTEN_TICKS, 0.0

    def begin(self) -> None:
        """Take over the robot where it was put down."""
        self._navigator.cancel()
        self._drive = None
        self._listening, self._since = LISTEN_TICKS, self._world.truth().metres

    def lead(self) -> Wheels:
        """The wheels for a tick."""
        sensors, metres = self._robot.sensors(), self._world.truth().metres
        if self._drive is None or self._drive.done:
            room = self._rooms[int(self._random.integers(len(self._rooms)))]
            self._drive = self._navigator.start(self._navigator.floor.place(room), sensors)
        if metres - self._since >= LISTEN_EVERY:
            self._since, self._listening = metres, LISTEN_TICKS
        if self._listening:
            self._listening -= 1
            return STOP
        return self._navigator.step(sensors)


@dataclass
class Outcome:
    """What became of one place; metres from where the robot was put down."""

    metres: float = 0.0
    noticed: float | None = None
    right_since: float | None = None
    lost: bool = False

    def take_in(self, metres: float, *, lost: bool, right: bool) -> None:
        """What the navigator says after so many metres, and whether it is right."""
        self.metres, self.lost = metres, lost
        if lost and self.noticed is None:
            self.noticed = metres
        if not right:
            self.right_since = None
        elif self.right_since is None:
            self.right_since = metres

    @property
    def settled(self) -> bool:
        """Whether the answers have been right for long enough."""
        return self.right_since is not None and self.metres - self.right_since >= SURE


def row_of(outcomes: list[Outcome]) -> dict[str, float | int]:
    """The figures under the names that are printed."""
    found = [one.right_since for one in outcomes if one.settled and one.right_since is not None]
    noticed = [one.noticed for one in outcomes if one.noticed is not None]
    missed = [one for one in outcomes if not one.settled]
    return {
        "places": len(outcomes),
        "found": len(found),
        "noticed": len(noticed),
        "median_metres_to_notice": round(float(np.median(noticed or [0.0])), 1),
        "median_metres_to_know": round(float(np.median(found or [0.0])), 1),
        "p90_metres_to_know": round(float(np.percentile(found or [0.0], 90)), 1),
        "lost_at_end": sum(one.lost for one in missed),
        "wrong_at_end": sum(not one.lost for one in missed),
        "km": round(sum(one.metres for one in outcomes) / 1000.0, 3),
    }


def random_pose(world: World, floor: Floor, random: np.random.Generator) -> Pose:
    """A pose on the true floor where the robot fits, in a corridor, hall or room."""
    spaces = world.plan.spaces
    areas = np.array([(s.high.x - s.low.x) * (s.high.y - s.low.y) for s in spaces])
    while True:
        space = spaces[int(random.choice(len(spaces), p=areas / areas.sum()))]
        x = float(random.uniform(space.low.x + 0.5, space.high.x - 0.5))
        y = float(random.uniform(space.low.y + 0.5, space.high.y - 0.5))
        if floor.free(x, y, clearance=0.45):
            return (x, y, float(random.uniform(-math.pi, math.pi)))


def is_right(world: World, navigator: Navigator) -> bool:
    """Whether the navigator knows where the robot is, and says so."""
    truth, here = world.truth(), navigator.localizer.estimate
    near = math.dist((truth.x, truth.y), (here.x, here.y)) <= NEAR
    return near and abs(wrap(truth.theta - here.theta)) <= TURNED and not navigator.localizer.lost


def kidnap(
    robot: RobotState, navigator: Navigator, guide: Guide, way: tuple[Pose, Pose]
) -> Outcome:
    """Let the robot know where it is, carry it off, and have it led about."""
    world, (start, end) = robot.world, way
    world.place_robot(*start)
    navigator.set_pose(start)
    for _ in range(20):
        world.step(0.0, 0.0)
        navigator.step(robot.sensors())
    world.place_robot(*end)
    guide.begin()
    outcome, began = Outcome(), world.truth().metres
    for _ in range(MOST_TICKS):
        wheels = guide.lead()
        world.step(wheels.speed, wheels.turn)
        navigator.step(robot.sensors())
        metres = world.truth().metres - began
        outcome.take_in(metres, lost=navigator.localizer.lost, right=is_right(world, navigator))
        if outcome.settled or metres > MOST_METRES:
            break
    return outcome


def run(
    places: int, seed: int, localizer: LocalizerName, profile: ProfileName, *, verbose: bool
) -> list[Outcome]:
    """Carry the robot off to so many places."""
    world = World(load_floor("wean5"), seed, PROFILES[profile])
    robot = RobotState(world, SimClock(0.0), speed=None)
    floor, true_floor = Floor(load_plan()), Floor(world.plan)
    navigator = Navigator(floor, localizer=make_localizer(localizer, floor, seed=seed))
    random, outcomes = np.random.default_rng(seed), list[Outcome]()
    guide = Guide(robot, np.random.default_rng(seed + 1))
    for _ in range(places):
        start = random_pose(world, true_floor, random)
        end = random_pose(world, true_floor, random)
        outcomes.append(kidnap(robot, navigator, guide, (start, end)))
        if verbose:
            print([round(value, 1) for value in end], outcomes[-1])
    return outcomes


def main() -> None:
    """Parse the command line and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--places", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--localizer", choices=get_args(LocalizerName), default="pomdp")
    parser.add_argument("--profile", choices=get_args(ProfileName), default="xavier")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    named = {name: getattr(options, name) for name in ("seed", "localizer", "profile")}
    outcomes = run(options.places, **named, verbose=options.verbose)
    row = {**named, **row_of(outcomes)}
    lines = [f"{name:24} {value}" for name, value in row.items()]
    print(json.dumps(row) if options.json else "\n".join(lines))


if __name__ == "__main__":
    main()
