"""Deliveries between random rooms in one lockstep run of the whole office.

    uv run python bench/deliveries.py --count 50 --seed 1

Prints what completed and why the rest did not, simulated hours, metres, wall time, and the
resident memory of each process at the beginning and at the end. Ends with 1 if fewer than 47 of
50 complete, if a failure has no reason, or if a process grew.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import os
import random
import socket
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from navigate.messages import Rooms
from rogue.messages import DeliveryRequest, ListRequests, PostRequest, RequestState
from rogue.office import OfficeOptions, office_specs
from rogue.requests import load_directory
from tca_bus import BusOptions, Module
from tca_bus.launcher import Launcher
from xavier_sim.messages import WhereReally

PROCESSES = ("router", "central", "xavier", "speech", "navigate", "rogue")
SHARE = 47 / 50
GROWTH = 1.1
"""By how much the last third of a process's memory samples may exceed the middle third."""

PAGE = os.sysconf("SC_PAGE_SIZE")


@dataclass
class Run:
    """What is measured."""

    launcher: Launcher
    module: Module
    memory: dict[str, list[float]] = field(default_factory=dict)

    def sample(self) -> None:
        """Note the resident memory of each process, in MB."""
        for name in PROCESSES:
            pid = self.launcher.pid(name)
            if pid is not None:
                pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
                self.memory.setdefault(name, []).append(pages * PAGE / 1e6)


async def post_all(run: Run, *, count: int, seed: int, at_once: int) -> None:
    """Post errands between random rooms, never more than ``at_once`` open, until all ended."""
    rng = random.Random(seed)
    directory = load_directory()
    pairs = [(user, item) for user in directory.people for item in directory.items]
    rooms = [room.room for room in await run.module.query(Rooms())]
    posted = 0
    while True:
        open_now = await run.module.query(ListRequests(open_only=True))
        if posted == count and not open_now:
            return
        taken = {(one.user, one.item) for one in open_now}
        for _ in range(min(at_once - len(open_now), count - posted)):
            user, item = rng.choice([pair for pair in pairs if pair not in taken])
            taken.add((user, item))
            start, end = rng.sample(rooms, 2)
            posted += 1
            await run.module.query(
                PostRequest(
                    id=f"d{posted:03d}",
                    user=user,
                    item=item,
                    pickup=start,
                    deliver=end,
                    deadline="12h",
                )
            )
        run.sample()
        await asyncio.sleep(1.0)


def report(
    run: Run, found: list[DeliveryRequest], seconds: tuple[float, float], metres: float
) -> int:
    """Print the figures; the exit code."""
    states = Counter(one.state.value for one in found)
    print(", ".join(f"{count} {state}" for state, count in sorted(states.items())))
    for one in found:
        if one.state is not RequestState.COMPLETED:
            print(f"  {one.id} {one.pickup} to {one.deliver}: {one.state.value}: {one.reason}")
    simulated, wall = seconds
    print(
        f"{simulated / 3600:.2f} simulated hours in {wall:.0f} s ({simulated / wall:.0f} times "
        f"real time), {metres:.0f} m driven"
    )
    grown = report_memory(run)
    enough = states[RequestState.COMPLETED.value] >= math.ceil(SHARE * len(found) - 1e-9)
    reasons = all(one.reason for one in found if one.state is not RequestState.COMPLETED)
    return 0 if enough and reasons and not grown else 1


def report_memory(run: Run) -> list[str]:
    """Print the memory of each process as it went; the names of those that grew."""
    grown = []
    print("MB          first  at 1/3  at 2/3    last    most")
    for name, samples in run.memory.items():
        third = max(1, len(samples) // 3)
        middle, last = max(samples[third : 2 * third] or samples), max(samples[-third:])
        flat = last <= middle * GROWTH
        if not flat:
            grown.append(name)
        values = (samples[0], samples[third - 1], samples[2 * third - 1], samples[-1], max(samples))
        word = "flat" if flat else "grew"
        print(f"{name:9s}" + "".join(f"{value:8.1f}" for value in values) + f"  {word}")
    return grown


async def measure(count: int, seed: int, at_once: int, folder: Path) -> int:
    """Run the office and the errands."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    bus = BusOptions(connect=f"tcp/127.0.0.1:{port}", realm="bench", clock="sim")
    specs = office_specs(OfficeOptions(data=folder, seed=seed, speed="max"), bus)
    async with (
        Launcher(specs, bus, log_dir=folder / "logs") as launcher,
        Module(f"bench-{os.getpid()}", options=bus) as module,
    ):
        run = Run(launcher, module)
        before, begun = await module.query(WhereReally()), time.monotonic()
        await post_all(run, count=count, seed=seed, at_once=at_once)
        after, wall = await module.query(WhereReally()), time.monotonic() - begun
        found = await module.query(ListRequests())
    return report(run, found, (after.time - before.time, wall), after.metres - before.metres)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--at-once", type=int, default=3, help="most errands open at a time")
    parser.add_argument("--data", type=Path, help="folder to keep; a temporary one if not given")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rogue-bench-") as temporary:
        folder = options.data or Path(temporary)
        sys.exit(asyncio.run(measure(options.count, options.seed, options.at_once, folder)))


if __name__ == "__main__":
    main()
