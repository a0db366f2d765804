"""The whole office in lockstep over Zenoh, all its processes, while the robot drives."""

from __future__ import annotations

import os
import random
import socket
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from navigate.messages import NavigateToGoal, Rooms
from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions, Module, TaskFailedError
from tca_bus.launcher import Launcher, ProcessSpec
from xavier_sim.messages import WhereReally

PROCESSES = ("router", "central", "xavier", "speech", "navigate", "rogue")

LONGEST = 1200.0
"""Simulated seconds that a drive may take."""


Links = Literal["router", "direct"]


@dataclass(frozen=True, kw_only=True)
class StackRun:
    """What came of driving: how far and how long, and what each process used meanwhile.

    ``simulated`` and ``wall`` are seconds, ``spent`` those of the processor by process.
    """

    links: Links
    drives: int
    arrived: int
    metres: float
    simulated: float
    wall: float
    spent: dict[str, float]

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per wall second."""
        return self.simulated / self.wall

    @property
    def costs(self) -> dict[str, float]:
        """Milliseconds of processor time for a simulated second, by process."""
        return {name: 1000.0 * used / self.simulated for name, used in self.spent.items()}


async def measure_stack(drives: int, folder: Path, *, links: Links, seed: int = 1) -> StackRun:
    """Drive to so many rooms at random, all processes started as ``rogue up`` starts them.

    The robot's rays are numba's where it is installed.
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    endpoint = f"tcp/127.0.0.1:{port}"
    bus = BusOptions(connect=endpoint, realm="bench", clock="sim", links=links)
    specs = office_specs(OfficeOptions(data=folder, seed=seed, speed="max"), bus)
    async with (
        Launcher(_compiled(specs), bus, log_dir=folder / "logs") as launcher,
        Module(f"bench-{os.getpid()}", options=bus) as module,
    ):
        await module.wait_for(Rooms, NavigateToGoal, WhereReally, timeout=30.0)
        before, began = await module.query(WhereReally()), time.monotonic()
        spent = processor_seconds(launcher)
        arrived = await _drive_about(module, drives, random.Random(seed))
        after, wall = await module.query(WhereReally()), time.monotonic() - began
        used = {name: now - spent[name] for name, now in processor_seconds(launcher).items()}
    return StackRun(
        links=links,
        drives=drives,
        arrived=arrived,
        metres=after.metres - before.metres,
        simulated=after.time - before.time,
        wall=wall,
        spent=used,
    )


async def _drive_about(module: Module, drives: int, chance: random.Random) -> int:
    """Drive to random rooms one after the other; gives how often it arrived."""
    rooms, arrived = await module.query(Rooms()), 0
    for _ in range(drives):
        room = chance.choice(rooms)
        try:
            goal = await module.expand(NavigateToGoal(x=room.x, y=room.y))
            await goal.result(timeout=LONGEST)
            arrived += 1
        except TaskFailedError as error:
            print(f"{room.room}: {error}")
    return arrived


def _compiled(specs: Sequence[ProcessSpec]) -> list[ProcessSpec]:
    return [
        replace(spec, env={**spec.env, "XAVIER_RAYS": "auto"}) if spec.name == "xavier" else spec
        for spec in specs
    ]


def processor_seconds(launcher: Launcher) -> dict[str, float]:
    """What each process has used so far; of one that is gone nothing."""
    used = {}
    for name in PROCESSES:
        stat = Path(f"/proc/{launcher.pid(name)}/stat")
        if stat.exists():
            fields = stat.read_text().rpartition(")")[2].split()
            used[name] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return used
