"""Our simulator beside navground and IR-SIM, on one floor, with the same rays, on one core.

    uv run --group sim python bench/sim.py
    uv run python bench/sim.py --stack      # all processes in lockstep over Zenoh

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

import numpy as np
from simulators import SIMULATORS, Simulator
from simulators.base import LIDAR_BEAMS, PERIOD, SONAR_RAYS, STRIPER_BEAMS, WALLS
from simulators.stack import measure_stack

GROUPS = {
    "lidar": f"World alone: {LIDAR_BEAMS} rays a tick with noise, robots told to drive circles",
    "loop": f"Whole loop: {SONAR_RAYS} + {STRIPER_BEAMS} rays a tick with noise, and a controller",
}

Times = dict[tuple[str, int], float]


def measure(names: list[str], counts: list[int], rounds: int, seconds: float) -> Times:
    """Milliseconds of processor time for a tick, by contender and number of robots."""
    times: Times = {}
    for count in counts:
        present = [SIMULATORS[name](count) for name in names if SIMULATORS[name].missing() is None]
        for one in present:
            _warm(one)
        seen: dict[str, list[float]] = {one.title: [] for one in present}
        for _ in range(rounds):
            for one in present:
                seen[one.title].append(_spell(one, seconds))
        times.update({(title, count): statistics.median(all_) for title, all_ in seen.items()})
    return times


def report(times: Times, names: list[str], counts: list[int]) -> str:
    """A table for each group, and what could not be measured."""
    parts = [f"{len(WALLS)} walls, doors open."]
    for group, heading in GROUPS.items():
        titles = [SIMULATORS[name].title for name in names if SIMULATORS[name].group == group]
        parts.append(f"**{heading}**\n\n{_table(times, titles, counts)}")
    missing = {SIMULATORS[name].missing() for name in names} - {None}
    parts += [f"Not measured: {why}." for why in sorted(map(str, missing))]
    return "\n\n".join(parts)


def main() -> None:
    """Read the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 10, 50])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=0.5, help="of a spell of one contender")
    parser.add_argument("--only", nargs="+", choices=SIMULATORS, default=list(SIMULATORS))
    parser.add_argument("--stack", action="store_true", help="all our processes over Zenoh")
    parser.add_argument("--drives", type=int, default=20, help="of --stack")
    flags = parser.parse_args()
    if flags.stack:
        with tempfile.TemporaryDirectory(prefix="xavier-bench-") as folder:
            print(asyncio.run(measure_stack(flags.drives, Path(folder))))
        return
    print(report(measure(flags.only, flags.robots, flags.rounds, flags.seconds), flags.only,
                 flags.robots))  # fmt: skip


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


def _table(times: Times, titles: list[str], counts: list[int]) -> str:
    head = [
        "",
        *(f"{count} robot{'s' * (count > 1)}: ms | x real time | ratio" for count in counts),
    ]
    lines = ["| " + " | ".join(head) + " |", "|---" * (1 + 3 * len(counts)) + "|"]
    for title in titles:
        if (title, counts[0]) not in times:
            continue
        cells = [title]
        for count in counts:
            cells += _cells(times, titles[0], title, count)
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cells(times: Times, base: str, title: str, count: int) -> list[str]:
    spent, ours = times.get((title, count)), times.get((base, count))
    if spent is None or ours is None:
        return ["", "", ""]
    return [f"{spent:.3g}", f"{1000.0 * PERIOD / spent:.3g}", f"{spent / ours:.2f}"]


if __name__ == "__main__":
    main()
