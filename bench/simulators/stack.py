"""The whole office in lockstep over Zenoh, all its processes, while the robot drives."""

from __future__ import annotations

import os
import random
import socket
import time
from pathlib import Path

from navigate.messages import NavigateToGoal, Rooms
from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions, Module, TaskFailedError
from tca_bus.launcher import Launcher
from xavier_sim.messages import WhereReally

PROCESSES = ("router", "central", "xavier", "speech", "navigate", "rogue")

LONGEST = 1200.0
"""Simulated seconds that a drive may take."""


async def measure_stack(drives: int, folder: Path, *, seed: int = 1) -> str:
    """Drive to so many rooms at random, and say how fast simulated time went meanwhile."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    bus = BusOptions(connect=f"tcp/127.0.0.1:{port}", realm="bench", clock="sim")
    specs = office_specs(OfficeOptions(data=folder, seed=seed, speed="max"), bus)
    chance = random.Random(seed)
    async with (
        Launcher(specs, bus, log_dir=folder / "logs") as launcher,
        Module(f"bench-{os.getpid()}", options=bus) as module,
    ):
        rooms = await module.query(Rooms())
        before, began, arrived = await module.query(WhereReally()), time.monotonic(), 0
        spent = processor_seconds(launcher)
        for _ in range(drives):
            room = chance.choice(rooms)
            try:
                goal = await module.expand(NavigateToGoal(x=room.x, y=room.y))
                await goal.result(timeout=LONGEST)
                arrived += 1
            except TaskFailedError as error:
                print(f"{room.room}: {error}")
        after, wall = await module.query(WhereReally()), time.monotonic() - began
        costs = {name: now - spent[name] for name, now in processor_seconds(launcher).items()}
    simulated = after.time - before.time
    return (
        f"{arrived} of {drives} drives arrived, {after.metres - before.metres:.0f} m; "
        f"{simulated:.0f} simulated seconds in {wall:.1f} s: {simulated / wall:.0f} x real time; "
        f"milliseconds of processor time for a simulated second: "
        + ", ".join(f"{name} {1000 * cost / simulated:.1f}" for name, cost in costs.items())
    )


def processor_seconds(launcher: Launcher) -> dict[str, float]:
    """What each process has used so far; of one that is gone nothing."""
    used = {}
    for name in PROCESSES:
        stat = Path(f"/proc/{launcher.pid(name)}/stat")
        if stat.exists():
            fields = stat.read_text().rpartition(")")[2].split()
            used[name] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return used
