"""Random drives from room to room in the simulated world, in one process, without a network.

    python bench/drives.py --drives 100 --seed 0

Deterministic by seed. Prints how many arrived, why others did not, bumps, errors, speed, and what
the navigator costs a tick.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from navigate.driving import Drive, Wheels
from navigate.maps import Floor, load_plan
from navigate.navigator import Navigator
from navigate.position import DEFAULT_LOCALIZER, LocalizerName, make_localizer
from xavier_sim.floors import load_floor
from xavier_sim.messages import Sensors
from xavier_sim.profile import PROFILES
from xavier_sim.robot import Reading
from xavier_sim.world import World

ARRIVED = 0.25
MOST_TICKS = 6000
LONG = 5.0
"""Metres beyond which a drive counts for the median speed."""


@dataclass
class Tally:
    """What all drives came to."""

    drives: int = 0
    arrived: int = 0
    reasons: Counter[str] = field(default_factory=Counter)
    errors: list[float] = field(default_factory=list)
    metres: float = 0.0
    ticks: int = 0
    recoveries: int = 0
    bumps: int = 0
    speeds: list[float] = field(default_factory=list)
    waited: float = 0.0
    touched: int = 0
    hit: int = 0
    hardest: float = 0.0
    cpu: float = 0.0
    slowest: float = 0.0

    def row(self) -> dict[str, float | int | str]:
        """The figures under the names that are printed."""
        seconds = self.ticks * 0.1
        return {
            "drives": self.drives,
            "arrived": self.arrived,
            "failures": ", ".join(f"{name} {n}" for name, n in sorted(self.reasons.items())),
            "bumps": self.bumps,
            "recoveries_per_km": round(1000 * self.recoveries / max(self.metres, 1.0), 2),
            "mean_error_m": round(float(np.mean(self.errors or [0.0])), 3),
            "worst_error_m": round(max(self.errors, default=0.0), 3),
            "km": round(self.metres / 1000, 3),
            "hours": round(seconds / 3600, 3),
            "speed_mps": round(self.metres / max(seconds, 0.1), 3),
            "median_mps": round(float(np.median(self.speeds or [0.0])), 3),
            "waited_s": round(self.waited, 1),
            "people_touched": self.touched,
            "people_hit": self.hit,
            "hardest_hit_mps": round(self.hardest, 3),
            "cpu_ms_per_tick": round(1000 * self.cpu / max(self.ticks, 1), 3),
            "worst_tick_ms": round(1000 * self.slowest, 1),
        }


def sensors_of(reading: Reading) -> Sensors:
    """The message that a reading is sent as."""
    return Sensors.model_construct(
        tick=reading.tick,
        time=reading.tick * 0.1,
        period=0.1,
        lockstep=True,
        sonar=reading.sonar,
        sonar_fresh=reading.sonar_fresh,
        odom=reading.odom,
        speed=reading.speed,
        turn_rate=reading.turn_rate,
        bump=reading.bump,
        striper=reading.striper,
        lidar=reading.lidar,
    )


def drive_to(world: World, navigator: Navigator, room: str, tally: Tally) -> None:
    """One drive, added to the tally."""
    before = world.truth()
    drive = navigator.start(navigator.floor.place(room), sensors_of(world.reading))
    for _ in range(MOST_TICKS):
        wheels = timed_step(navigator, sensors_of(world.reading), tally)
        if drive.done:
            break
        world.step(wheels.speed, wheels.turn)
    after = world.truth()
    tally.drives += 1
    tally.metres += after.metres - before.metres
    tally.bumps += after.bumps - before.bumps
    tally.recoveries += drive.recoveries
    tally.waited += drive.courtesy.waited
    tally.touched, tally.hit = after.people_touched, after.people_hit
    tally.hardest = after.hardest_hit
    if after.metres - before.metres > LONG:
        tally.speeds.append((after.metres - before.metres) / (0.1 * (after.tick - before.tick)))
    judge(world, drive, room, tally)
    navigator.cancel()


def timed_step(navigator: Navigator, sensors: Sensors, tally: Tally) -> Wheels:
    """One step of the navigator, with its cost added to the tally."""
    began = time.process_time()
    wheels = navigator.step(sensors)
    spent = time.process_time() - began
    tally.cpu += spent
    tally.slowest = max(tally.slowest, spent)
    tally.ticks += 1
    return wheels


def judge(world: World, drive: Drive, room: str, tally: Tally) -> None:
    """Add to the tally how a drive ended, by the truth."""
    truth, place = world.truth(), world.plan.places[room]
    error = math.dist((truth.x, truth.y), (place.x, place.y))
    if drive.failure:
        tally.reasons[drive.failure.reason] += 1
    elif not drive.done:
        tally.reasons["endless"] += 1
    else:
        tally.errors.append(error)
        tally.arrived += error <= ARRIVED
        tally.reasons.update(["elsewhere"] if error > ARRIVED else [])


def shut_doors(world: World, share: float, spare: set[str], random: np.random.Generator) -> None:
    """Shut a share of the doors, but for those of the rooms to ``spare``."""
    for room in sorted(world.plan.places):
        world.set_door(room, is_open=room in spare or random.random() >= share)


def run(
    drives: int,
    seed: int,
    *,
    localizer: LocalizerName = DEFAULT_LOCALIZER,
    shut: float = 0.0,
    profile: str = "xavier",
    people: int = 0,
    carts: int = 0,
    verbose: bool = False,
) -> Tally:
    """Drive to ``drives`` random rooms one after the other in the world of ``seed``."""
    world = World(load_floor("wean5"), seed, PROFILES[profile], people=people, carts=carts)
    floor = Floor(load_plan())
    navigator = Navigator(floor, localizer=make_localizer(localizer, floor, seed=seed))
    rooms = sorted(world.plan.places)
    random, tally = np.random.default_rng(seed), Tally()
    here = ""
    for _ in range(drives):
        before, here = here, rooms[int(random.integers(len(rooms)))]
        if shut > 0.0:
            shut_doors(world, shut, {before, here}, random)
        drive_to(world, navigator, here, tally)
        if verbose:
            print(here, world.truth(), navigator.position(), tally.row())
    return tally


def main() -> None:
    """Parse the command line and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=100)
    parser.add_argument("--seed", type=int, action="append")
    parser.add_argument("--localizer", choices=get_args(LocalizerName), default=DEFAULT_LOCALIZER)
    parser.add_argument("--shut", type=float, default=0.0, help="share of other doors shut")
    parser.add_argument("--profile", choices=sorted(PROFILES), default="xavier")
    parser.add_argument("--people", type=int, default=0, help="who walk the corridors")
    parser.add_argument("--carts", type=int, default=0, help="that stand in the corridors")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    for seed in options.seed or [0]:
        row = {"seed": seed, "localizer": options.localizer, **run_row(options, seed)}
        print(json.dumps(row) if options.json else _table(row))


def run_row(options: argparse.Namespace, seed: int) -> dict[str, float | int | str]:
    """The figures of one seed."""
    tally = run(
        options.drives,
        seed,
        localizer=options.localizer,
        shut=options.shut,
        profile=options.profile,
        people=options.people,
        carts=options.carts,
        verbose=options.verbose,
    )
    return tally.row()


def _table(row: dict[str, float | int | str]) -> str:
    return "\n".join(f"{name:20} {value}" for name, value in row.items()) + "\n"


if __name__ == "__main__":
    main()
