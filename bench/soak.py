"""Soaks beside each other: with each fault, and with each way to know where the robot is.

    python bench/soak.py --hours 4 --seed 1 --faults --localizers

One after the other in this process, so that all have the same errands and the same doors; prints
one Markdown table. ``--people``, ``--carts`` and ``--profile`` are as in ``xavier soak``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator

from xavier_sim.soak import FAULT_KINDS, Rate, SoakOptions, SoakRun, Summary

LOCALIZERS = ("odometry", "particles", "pomdp")
COLUMNS = (
    "run", "jobs", "km", "reachable: completed", "unreachable: refused", "false arrivals", "bumps",
    "people hit", "recoveries/km", "rescues", "median m/s", "position error, median / 99 % m",
    "x real time (CPU)", "reasons",
)  # fmt: skip


def variants(flags: argparse.Namespace) -> Iterator[tuple[str, SoakOptions]]:
    """The runs that the command line asks for, with their names."""
    plain = SoakOptions(
        seed=flags.seed, profile=flags.profile, people=flags.people, carts=flags.carts
    )
    yield "plain", plain
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
        summary.cpu_time_factor, ", ".join(f"{key} {n}" for key, n in summary.reasons.items()),
    )  # fmt: skip
    return _line(cells)


def main() -> None:
    """Parse the command line, run, and print the table row by row."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=4.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--profile", default="xavier", choices=("hard", "modern", "xavier"))
    parser.add_argument("--people", type=int, default=0)
    parser.add_argument("--carts", type=int, default=0)
    parser.add_argument("--faults", nargs="*", choices=FAULT_KINDS, help="all when none is named")
    parser.add_argument("--localizers", nargs="*", help="all when none is named")
    flags = parser.parse_args()
    if flags.faults == []:
        flags.faults = [
            kind for kind in FAULT_KINDS if kind != "laser" or flags.profile != "xavier"
        ]
    if flags.localizers == []:
        flags.localizers = list(LOCALIZERS)
    print(_line(COLUMNS), _line("---" for _ in COLUMNS), sep="\n")
    for name, options in variants(flags):
        run = SoakRun(options)
        for job in run.jobs(flags.hours):
            print(f"{name}: {job.number}, {job.outcome}", end="\r", file=sys.stderr)
        print(row(name, run.summary()), flush=True)


def _rate(rate: Rate) -> str:
    share = f" ({100 * rate.share:.1f} %)" if rate.share is not None else ""
    return f"{rate.right} of {rate.jobs}{share}"


def _line(cells: Iterable[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


if __name__ == "__main__":
    main()
