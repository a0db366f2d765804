"""Every door in and out: how often the robot gets stuck, gets free again, and gives up.

    python bench/doors.py --times 20 --profile hard --seed 0

One process, without a network; deterministic by seed. From the corridor before a room's door the
robot is sent to the room and back, so many times, then on to the next room.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, field
from typing import get_args

from navigate.driving import DoorTally
from navigate.maps import Floor, Point, load_plan
from navigate.navigator import Navigator
from navigate.position import DEFAULT_LOCALIZER, LocalizerName, make_localizer
from xavier_sim.floors import load_floor
from xavier_sim.profile import PROFILES
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

MOST_TICKS = 6000


@dataclass
class Passages:
    """What the drives through the doors came to."""

    drives: int = 0
    failed: dict[str, int] = field(default_factory=dict)
    ticks: int = 0


def drive_to(robot: RobotState, navigator: Navigator, goal: Point, done: Passages) -> None:
    """One drive, counted."""
    drive = navigator.start(goal, robot.sensors())
    for _ in range(MOST_TICKS):
        wheels = navigator.step(robot.sensors())
        if drive.done:
            break
        robot.world.step(wheels.speed, wheels.turn)
        done.ticks += 1
    navigator.cancel()
    done.drives += 1
    if drive.failure is not None:
        reason = str(drive.failure.reason)
        done.failed[reason] = done.failed.get(reason, 0) + 1


def run(options: argparse.Namespace) -> tuple[Navigator, World, Passages]:
    """In and out of every room."""
    profile = PROFILES[options.profile]
    world = World(load_floor("wean5"), options.seed, profile, people=options.people)
    robot, floor = RobotState(world, SimClock(0.0), speed=None), Floor(load_plan())
    localizer = make_localizer(options.localizer, floor, seed=options.seed)
    navigator, done = Navigator(floor, localizer=localizer), Passages()
    for room in sorted(floor.places)[: options.rooms]:
        for _ in range(options.times):
            drive_to(robot, navigator, floor.place(room), done)
            drive_to(robot, navigator, navigator.planner.graph.before(room)[0], done)
    return navigator, world, done


def total(doors: dict[str, DoorTally]) -> DoorTally:
    """The sum of the records."""
    names = DoorTally.__dataclass_fields__
    return DoorTally(*(sum(getattr(one, name) for one in doors.values()) for name in names))


def rates(tally: DoorTally, done: Passages, bumps: int) -> dict[str, float | int | str]:
    """The figures of all doors under the names that are printed."""
    passages = max(1, tally.passed + tally.given_up)
    return {
        "drives": done.drives,
        "failures": ", ".join(f"{name} {n}" for name, n in sorted(done.failed.items())),
        "passed": tally.passed,
        "tries_per_passage": round(tally.tries / passages, 3),
        "stuck_percent": round(100 * tally.stuck / passages, 2),
        "recovered_percent_of_stuck": round(100 * tally.recovered / max(1, tally.stuck), 1),
        "given_up_percent": round(100 * tally.given_up / passages, 2),
        "found_shut": tally.shut,
        "bumps": bumps,
        "hours": round(done.ticks / 36000, 2),
    }


def table(doors: dict[str, DoorTally]) -> str:
    """One line for each door that was tried more often than it was passed, or got stuck in."""
    names = list(DoorTally.__dataclass_fields__)
    lines = ["door      " + "".join(f"{name:>11}" for name in names)]
    for door, one in sorted(doors.items()):
        if one.stuck or one.tries > one.passed:
            lines.append(f"{door:10}" + "".join(f"{getattr(one, name):11}" for name in names))
    return "\n".join(lines)


def main() -> None:
    """Parse the command line, drive, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=20, help="in and out of each room")
    parser.add_argument("--rooms", type=int, help="only so many rooms")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--profile", choices=sorted(PROFILES), default="xavier")
    parser.add_argument("--localizer", choices=get_args(LocalizerName), default=DEFAULT_LOCALIZER)
    parser.add_argument("--people", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    navigator, world, done = run(options)
    doors = navigator.doors.doors
    figures = rates(total(doors), done, world.truth().bumps)
    if options.json:
        counts = {
            name: {key: getattr(one, key) for key in DoorTally.__dataclass_fields__}
            for name, one in doors.items()
        }
        print(json.dumps({"seed": options.seed, **figures, "doors": counts}))
        return
    print(table(doors))
    print("\n".join(f"{name:28} {value}" for name, value in figures.items()))


if __name__ == "__main__":
    main()
