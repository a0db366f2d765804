"""Our simulator beside navground and IR-SIM, on one floor, with the same rays, on one core.

    uv run --group sim python bench/sim.py
    uv run python bench/sim.py --stack                  # all processes in lockstep over Zenoh
    uv run python bench/sim.py --stack --links direct   # the same, without a router between them

Each contender and number of robots is set up once; then all are measured in turn, round by round,
by processor time, so that a busy machine is equally bad for all. What counts are the ratios. A
simulator that this machine lacks is named and left out.
"""

from __future__ import annotations

import argparse
import asyncio
import statistics
import tempfile
import time
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np
from simulators import SIMULATORS, Simulator
from simulators.base import BARE, FURNISHED, PERIOD, SONAR_RAYS, STRIPER_BEAMS
from simulators.stack import Links, StackRun, measure_stack

GROUPS = {
    "lidar": f"World alone: {len(BARE.walls)} walls, {BARE.beams} rays with noise, no controller",
    "furnished": f"The same with {len(FURNISHED.walls)} walls and {FURNISHED.beams} rays",
    "loop": f"Whole loop: {SONAR_RAYS} + {STRIPER_BEAMS} rays a tick with noise, and a controller",
}

Times = dict[tuple[str, str, int], float]


class Aim(NamedTuple):
    """So many times the ratio to a contender, by group and number of robots."""

    what: str
    group: str
    rival: str
    robots: int
    ratio: float


AIMS = (
    Aim("furnished floor, one robot: 4 times navground", "furnished", "navground", 1, 4.0),
    Aim("the same: 40 times IR-SIM", "furnished", "IR-SIM", 1, 40.0),
    Aim("the same with 50 robots: ahead of navground", "furnished", "navground", 50, 1.0),
    Aim("the same with 50 robots: ahead of IR-SIM", "furnished", "IR-SIM", 50, 1.0),
    Aim("bare floor, whole loop, one robot: 4 times navground", "loop", "navground", 1, 4.0),
    Aim("the same: 40 times IR-SIM", "loop", "IR-SIM", 1, 40.0),
    Aim("the same with 50 robots: ahead of navground", "loop", "navground", 50, 1.0),
    Aim("the same with 50 robots: ahead of IR-SIM", "loop", "IR-SIM", 50, 1.0),
)
"""What was hoped for, as docs/benchmarks.md lists it."""

STACK_AIM = 60.0
"""Times real time that the whole stack is to run at."""


def measure(names: list[str], counts: list[int], rounds: int, seconds: float) -> Times:
    """Milliseconds of processor time for a tick, by contender and number of robots."""
    times: Times = {}
    for count in counts:
        present = [SIMULATORS[name](count) for name in names if SIMULATORS[name].missing() is None]
        for one in present:
            _warm(one)
        seen: dict[tuple[str, str], list[float]] = {(one.group, one.title): [] for one in present}
        for _ in range(rounds):
            for one in present:
                seen[one.group, one.title].append(_spell(one, seconds))
        times.update({(*who, count): statistics.median(spent) for who, spent in seen.items()})
    return times


def report(times: Times, names: list[str], counts: list[int]) -> str:
    """A table for each group, and what could not be measured."""
    parts = list[str]()
    for group, heading in GROUPS.items():
        rows = {key[1:]: spent for key, spent in times.items() if key[0] == group}
        if rows:
            parts.append(f"**{heading}**\n\n{_table(rows, counts)}")
    if compared := [line for aim in AIMS if (line := _compare(aim, times)) is not None]:
        parts.append("\n".join(["| aim | seen | |", "|---|---:|---|", *compared]))
    missing = {SIMULATORS[name].missing() for name in names} - {None}
    parts += [f"Not measured: {why}." for why in sorted(map(str, missing))]
    return "\n\n".join(parts)


def report_stack(run: StackRun) -> str:
    """One paragraph, and the row of the table of aims."""
    factor = run.real_time_factor
    costs = ", ".join(f"{name} {cost:.1f}" for name, cost in run.costs.items())
    return (
        f"{run.arrived} of {run.drives} drives arrived, {run.metres:.0f} m; links {run.links}; "
        f"{run.simulated:.0f} simulated seconds in {run.wall:.1f} s. Milliseconds of processor "
        f"time for a simulated second: {sum(run.costs.values()):.1f}: {costs}\n\n"
        "| aim | seen | |\n|---|---:|---|\n| the whole stack over Zenoh in lockstep: "
        f"{STACK_AIM:.0f} times real time | {factor:.0f} | {_verdict(factor, STACK_AIM)} |"
    )


def main() -> None:
    """Read the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 10, 50])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=0.5, help="of a spell of one contender")
    parser.add_argument("--only", nargs="+", choices=SIMULATORS, default=list(SIMULATORS))
    parser.add_argument("--stack", action="store_true", help="all our processes over Zenoh")
    parser.add_argument("--drives", type=int, default=20, help="of --stack")
    parser.add_argument("--links", choices=get_args(Links), default="router", help="of --stack")
    flags = parser.parse_args()
    if flags.stack:
        with tempfile.TemporaryDirectory(prefix="xavier-bench-") as folder:
            run = asyncio.run(measure_stack(flags.drives, Path(folder), links=flags.links))
        print(report_stack(run))
        return
    print(report(measure(flags.only, flags.robots, flags.rounds, flags.seconds), flags.only,
                 flags.robots))  # fmt: skip


def _compare(aim: Aim, times: Times) -> str | None:
    """The row of an aim; None where a contender was not measured."""
    mine = next((key[1] for key in times if key[0] == aim.group and "xavier" in key[1]), None)
    rival = next((key[1] for key in times if key[0] == aim.group and aim.rival in key[1]), None)
    one, other = (times.get((aim.group, title or "", aim.robots)) for title in (mine, rival))
    if one is None or other is None:
        return None
    seen = other / one
    return f"| {aim.what} | {seen:.2g} | {_verdict(seen, aim.ratio)} |"


def _verdict(seen: float, wanted: float) -> str:
    return "met" if seen >= wanted else "missed"


def _warm(one: Simulator) -> None:
    """Run it in, and see that its scanner sees the walls."""
    for _ in range(20):
        one.tick()
    ranges = one.ranges()
    assert np.isfinite(ranges).any(), f"{one.title} measures nothing"
    assert ranges[np.isfinite(ranges)].min() < 6.0, f"{one.title} sees no wall of its room"


def _spell(one: Simulator, seconds: float) -> float:
    """Milliseconds of processor time for a tick, over a spell of wall time."""
    ticks, began, until = 0, time.process_time(), time.monotonic() + seconds
    while time.monotonic() < until:
        one.tick()
        ticks += 1
    return 1000.0 * (time.process_time() - began) / ticks


def _table(rows: dict[tuple[str, int], float], counts: list[int]) -> str:
    columns = (f"{count} robot{'s' * (count > 1)}: ms | x real time | ratio" for count in counts)
    lines = ["| " + " | ".join(["", *columns]) + " |", "|---" * (1 + 3 * len(counts)) + "|"]
    titles = list(dict.fromkeys(title for title, _ in rows))
    for title in titles:
        cells = [title]
        for count in counts:
            spent = rows[title, count]
            ratio = spent / rows[titles[0], count]
            cells += [f"{spent:.3g}", f"{1000.0 * PERIOD / spent:,.3g}", f"{ratio:.2f}"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
