"""ROGUE's planner beside others, on errands known at once and on errands that arrive.

    uv run --group bench python bench/planner.py
    uv run --group bench python bench/planner.py --only streams --seeds 20

Batches: one to eight deliveries among 12, 24 and 48 rooms on a ring. For each planner: how many
were solved, milliseconds to the first step, nodes, and metres over the shortest way, which a
dynamic program of its own finds. Streams: deliveries with priorities that arrive at random. For
each dispatcher: priority-weighted waiting, missed deadlines, metres, actions redone, and the
milliseconds of its reaction to an arrival. Reactions: the same for ROGUE with 8 and with 100
errands open, the choice of who takes part in the search among them. All times are of the
processor, so that other work on the machine does not count; what is timed in this process is done
three times, of which the quickest counts. Ends with 1 if one of the aims is missed, and says which.
Fast Downward takes part where it is installed.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable, Iterable

from planners.crowds import reaction
from planners.office import Instance, batch, shortest, stream
from planners.others import (
    downward,
    fast_downward,
    ortools_first,
    ortools_searching,
    pyperplan,
)
from planners.ours import Planned, plan
from planners.streams import Record, dispatch, first_come, nearest_first, ours, resolved

ROOMS = (12, 24, 48)
COUNTS = range(1, 9)
MOST_NODES = 150
MOST_TRAVEL = 1.03
REACTIONS = {8: 0.010, 100: 0.050}
"""Seconds in which the planner should react with so many errands open."""

TIMES = 3
"""Runs of which the quickest counts, for what is timed in this process."""

Planner = Callable[[Instance], Planned | None]


def planners() -> dict[str, Planner]:
    found: dict[str, Planner] = {
        "ROGUE": plan,
        "OR-Tools, first solution": ortools_first,
        "OR-Tools, 0.2 s search": ortools_searching,
        "pyperplan gbf hff": pyperplan,
    }
    if downward() is None:
        print("Fast Downward is not installed here: it takes no part.")
    else:
        found["Fast Downward lama-first"] = fast_downward
    return found


def milliseconds(values: Iterable[float]) -> str:
    listed = list(values)
    return f"{1e3 * statistics.median(listed):.1f}" if listed else "-"


def batches(seeds: int) -> list[str]:
    """Print the table of batches; gives the aims that were missed."""
    plan(batch(12, 8, -1))
    missed: list[str] = []
    by_planner = planners()
    print("\n| rooms | errands | planner | solved | first step, ms | nodes | travel / optimum |")
    print("|---|---|---|---|---|---|---|")
    for rooms in ROOMS:
        for count in COUNTS:
            instances = [batch(rooms, count, seed) for seed in range(seeds)]
            optimum = [shortest(one) for one in instances]
            for name, planner in by_planner.items():
                made = [_quickest(name, planner, one) for one in instances]
                missed += _batch_row(name, rooms, count, made, optimum)
    return missed


def _quickest(name: str, planner: Planner, instance: Instance) -> Planned | None:
    times = TIMES if name in ("ROGUE", "OR-Tools, first solution") else 1
    made = [planner(instance) for _ in range(times)]
    return min((one for one in made if one), key=lambda one: one.first, default=None)


def _batch_row(
    name: str, rooms: int, count: int, made: list[Planned | None], optimum: list[float]
) -> list[str]:
    good = [(one, best) for one, best in zip(made, optimum, strict=True) if one is not None]
    ratios = [one.metres / best if best else 1.0 for one, best in good]
    nodes = [one.nodes for one, _ in good if one.nodes is not None]
    solved, ratio = f"{len(good)}/{len(made)}", statistics.fmean(ratios) if ratios else 0.0
    first = milliseconds(one.first for one, _ in good)
    most = max(nodes, default="")
    cells = (rooms, count, name, solved, first, most, f"{ratio:.2f}")
    print(f"| {' | '.join(map(str, cells))} |", flush=True)
    if name != "ROGUE":
        return []
    where = f"{count} errands in {rooms} rooms"
    missed = [f"{where}: {solved} solved"] if len(good) < len(made) else []
    if max(nodes, default=0) > min(4 + 16 * count, MOST_NODES):
        missed.append(f"{where}: {max(nodes)} nodes")
    if count == max(COUNTS) and ratio > MOST_TRAVEL:
        missed.append(f"{where}: {ratio:.3f} times the shortest way")
    return missed


def streams(seeds: int, count: int, every: float) -> list[str]:
    """Print the table of streams; gives the aims that were missed."""
    dispatchers: dict[str, Callable[[Instance], Record]] = {
        "ROGUE": ours,
        "first come, first served": lambda one: dispatch(one, first_come),
        "nearest first": lambda one: dispatch(one, nearest_first),
        "OR-Tools re-solved, 0.1 s": lambda one: dispatch(one, resolved(0.1)),
    }
    instances = [stream(24, count, seed, every) for seed in range(seeds)]
    print(f"\nStreams: {seeds} of {count} errands in 24 rooms, one every {every:g} s")
    print("\n| dispatcher | weighted waiting, s | missed | metres | redone | reaction, ms |")
    print("|---|---|---|---|---|---|")
    waiting: dict[str, float] = {}
    missed: list[str] = []
    for name, dispatcher in dispatchers.items():
        records = [dispatcher(one) for one in instances]
        pairs = list(zip(records, instances, strict=True))
        waiting[name] = statistics.fmean(r.weighted_waiting(i.jobs) for r, i in pairs)
        late = sum(r.missed(i.jobs) for r, i in pairs)
        metres = statistics.fmean(r.metres for r in records)
        redone = sum(r.redone for r in records)
        reaction = milliseconds(t for r in records for t in r.reactions)
        print(
            f"| {name} | {waiting[name]:.0f} | {late} | {metres:.0f} | {redone} | {reaction} |",
            flush=True,
        )
        if name == "ROGUE" and redone:
            missed.append(f"streams: {redone} actions redone")
    return missed + _compared(waiting)


def reactions(seeds: int) -> list[str]:
    """Print how soon an arrival is acted on; gives the aims that were missed."""
    print("\n| open errands | reaction, ms: median | 90th of 100 |")
    print("|---|---|---|")
    missed: list[str] = []
    for count, aim in REACTIONS.items():
        taken = sorted(
            min(reaction(count, seed) for _ in range(TIMES)) for seed in range(4 * seeds)
        )
        late = taken[int(0.9 * len(taken))]
        median = statistics.median(taken)
        print(f"| {count} | {1e3 * median:.1f} | {1e3 * late:.1f} |", flush=True)
        if median > aim:
            missed.append(f"{count} open: reaction {1e3 * median:.1f} ms, aim {1e3 * aim:g} ms")
    return missed


def _compared(waiting: dict[str, float]) -> list[str]:
    own, aims = waiting["ROGUE"], dict.fromkeys(waiting, 1.0)
    aims["OR-Tools re-solved, 0.1 s"] = 1.1
    return [
        f"streams: waiting {own:.0f} s, {name} has {other:.0f} s"
        for name, other in waiting.items()
        if own > aims[name] * other
    ]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--only", choices=("batches", "streams", "reactions"))
    parser.add_argument("--seeds", type=int, default=5)
    options = parser.parse_args()
    missed: list[str] = []
    if options.only in (None, "batches"):
        missed += batches(options.seeds)
    if options.only in (None, "streams"):
        for every in (180.0, 120.0):
            missed += streams(2 * options.seeds, 40, every)
    if options.only in (None, "reactions"):
        missed += reactions(options.seeds)
    for one in missed:
        print(f"missed: {one}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
