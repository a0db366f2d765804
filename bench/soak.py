"""Soaks beside each other: with each fault, with each localizer, and with all over the bus.

    python bench/soak.py --hours 4 --seed 1 --faults --localizers
    python bench/soak.py --hours 4 --seed 1 --bus

One after the other, so that all have the same errands and the same doors; prints one Markdown
table. The plain run and those with faults and localizers have their cores in this process; with
``--bus`` the plain one is run again with all processes of the office, in lockstep over Zenoh.
``--map``, ``--people``, ``--carts`` and ``--profile`` are as in ``xavier soak``.
"""

from __future__ import annotations

import argparse
import asyncio
import functools
import sys
from collections.abc import Iterable, Iterator
from typing import get_args

from soaks.bus import soak_over_bus

from navigate.messages import LocalizerName
from xavier_sim.floors import DEFAULT_FLOOR
from xavier_sim.messages import ProfileName
from xavier_sim.profile import PROFILES
from xavier_sim.soak import (
    FAULT_KINDS,
    FaultKind,
    Job,
    Rate,
    SoakOptions,
    SoakRun,
    Summary,
    possible_faults,
)

LOCALIZERS = sorted(get_args(LocalizerName))
PLAIN, BUS = "plain", "over the bus"
COLUMNS = (
    "run", "jobs", "km", "reachable: completed", "unreachable: refused", "false arrivals", "bumps",
    "people hit", "recoveries/km", "rescues", "median m/s", "position error, median / 99 % m",
    "x real time", "by CPU time", "MB", "reasons",
)  # fmt: skip


def plain_options(flags: argparse.Namespace) -> SoakOptions:
    """The soak without a fault, with the navigator's own localizer."""
    return SoakOptions(
        seed=flags.seed,
        floor=flags.map,
        profile=flags.profile,
        people=flags.people,
        carts=flags.carts,
    )


def variants(flags: argparse.Namespace) -> Iterator[tuple[str, SoakOptions]]:
    """The runs in this process that the command line asks for, with their names."""
    plain = plain_options(flags)
    yield PLAIN, plain
    for name in flags.localizers or ():
        yield name, plain.model_copy(update={"navigator_options": {"localizer": name}})
    for kind in flags.faults or ():
        yield kind, plain.model_copy(update={"fault": kind})


def row(name: str, summary: Summary) -> str:
    """A run as a row of the table."""
    error = summary.position_error
    cells = (
        name, summary.jobs, summary.km, _rate(summary.reachable), _rate(summary.unreachable),
        summary.false_arrivals, summary.bumps, summary.people_hit, summary.recoveries_per_km,
        summary.rescues, summary.median_speed, f"{error.median} / {error.p99}",
        summary.real_time_factor, summary.cpu_time_factor, f"{summary.memory_mb[1]:.0f}",
        ", ".join(f"{key} {n}" for key, n in summary.reasons.items()),
    )  # fmt: skip
    return _line(cells)


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=4.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--map", default=DEFAULT_FLOOR)
    parser.add_argument("--profile", default="xavier", choices=get_args(ProfileName))
    parser.add_argument("--people", type=int, default=0)
    parser.add_argument("--carts", type=int, default=0)
    parser.add_argument("--faults", nargs="*", choices=FAULT_KINDS, help="all when none is named")
    parser.add_argument(
        "--localizers", nargs="*", choices=LOCALIZERS, help="all when none is named"
    )
    parser.add_argument("--bus", action="store_true", help="the plain run with all processes too")
    flags = parser.parse_args()
    flags.faults = faults_of(flags, parser)
    if flags.localizers == []:
        flags.localizers = LOCALIZERS
    return flags


def faults_of(flags: argparse.Namespace, parser: argparse.ArgumentParser) -> list[FaultKind]:
    """The kinds of faults to run: of all those that the robot can have, or an error."""
    possible = possible_faults(PROFILES[flags.profile])
    lacking = [kind for kind in flags.faults or FAULT_KINDS if kind not in possible]
    what = f"a robot of profile {flags.profile} has no sensor for {', '.join(lacking)}"
    if flags.faults and lacking:
        parser.error(f"--faults: {what}")
    if flags.faults == []:
        if lacking:
            print(f"not run: {what}", file=sys.stderr)
        return list(possible)
    return flags.faults or []


def main() -> None:
    """Run what the command line asks for, and print the table row by row."""
    flags = arguments()
    print(_line(COLUMNS), _line("---" for _ in COLUMNS), sep="\n")
    done = dict[str, list[Job]]()
    for name, options in variants(flags):
        run = SoakRun(options)
        for job in run.jobs(flags.hours):
            tell(name, job, run.soak.seconds)
        print(row(name, run.outcome().summary()), flush=True)
        done[name] = run.soak.course.tally.jobs
    if flags.bus:
        over_bus = functools.partial(tell, BUS)
        outcome = asyncio.run(soak_over_bus(plain_options(flags), flags.hours, over_bus))
        said = agreement(done[PLAIN], outcome.tally.jobs)
        print(row(BUS, outcome.summary()), said, sep="\n\n", flush=True)


def agreement(one: list[Job], other: list[Job]) -> str:
    """How many jobs of two runs came out the same, and from where they differ."""
    pairs = list(zip(one, other, strict=False))
    same = sum(a == b for a, b in pairs)
    alike = sum((a.goal, a.outcome) == (b.goal, b.outcome) for a, b in pairs)
    first = next((a.number for a, b in pairs if a != b), None)
    rest = "" if first is None else f"; they part at job {first}"
    return (
        f"Of {len(pairs)} jobs that both runs had, {same} are the same in every figure and "
        f"{alike} in goal and outcome{rest}."
    )


def tell(run: str, job: Job, seconds: float) -> None:
    """Say how far a run has come."""
    print(f"{run}: {seconds / 3600:.2f} h, job {job.number}: {job.outcome}", file=sys.stderr)


def _rate(rate: Rate) -> str:
    share = f" ({100 * rate.share:.1f} %)" if rate.share is not None else ""
    return f"{rate.right} of {rate.jobs}{share}"


def _line(cells: Iterable[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


if __name__ == "__main__":
    main()
