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
        Launcher(specs, bus, log_dir=folder / "logs"),
        Module(f"bench-{os.getpid()}", options=bus) as module,
    ):
        rooms = await module.query(Rooms())
        before, began, arrived = await module.query(WhereReally()), time.monotonic(), 0
        for _ in range(drives):
            room = chance.choice(rooms)
            try:
                goal = await module.expand(NavigateToGoal(x=room.x, y=room.y))
                await goal.result(timeout=LONGEST)
                arrived += 1
            except TaskFailedError as error:
                print(f"{room.room}: {error}")
        after, wall = await module.query(WhereReally()), time.monotonic() - began
    simulated = after.time - before.time
    return (
        f"{arrived} of {drives} drives arrived, {after.metres - before.metres:.0f} m; "
        f"{simulated:.0f} simulated seconds in {wall:.1f} s: {simulated / wall:.0f} x real time"
    )
