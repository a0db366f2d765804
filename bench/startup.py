"""What starting a command costs, and starting each process of the office until it is ready.

    uv run python bench/startup.py --rounds 5

Prints a table of processor milliseconds, user and system, the least of all rounds; what bytecode
saves is seen under ``PYTHONDONTWRITEBYTECODE=1``, with the folders ``__pycache__`` removed.
"""

from __future__ import annotations

import argparse
import asyncio
import dataclasses
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions
from tca_bus.launcher import Launcher, Ready, free_port

TICKS = os.sysconf("SC_CLK_TCK")
NOBODY = "tcp/127.0.0.1:1"
PACKAGES = ("tca_bus", "rogue", "navigate", "xavier_sim")
COMMANDS = {
    **{f"{package} --help": (package, "--help") for package in PACKAGES},
    "tca goal --help": ("tca_bus", "goal", "--help"),
    "tca modules, no bus": ("tca_bus", "modules", "--connect", NOBODY),
    "tca tree, no bus": ("tca_bus", "tree", "--connect", NOBODY),
    "rogue requests, no bus": ("rogue", "requests", "--connect", NOBODY),
    "rogue why 1, no bus": ("rogue", "why", "1", "--connect", NOBODY),
    "navigate where, no bus": ("navigate", "where", "--connect", NOBODY),
    "xavier where, no bus": ("xavier_sim", "where", "--connect", NOBODY),
}


def run_once(arguments: tuple[str, ...]) -> float:
    """Processor milliseconds of a command from start to end."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", *arguments], capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1e3 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def used(pid: int) -> float:
    """Processor milliseconds of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return 1e3 * (int(fields[11]) + int(fields[12])) / TICKS


@dataclasses.dataclass
class Metered:
    """What says that a process is ready, and then what it has used so far."""

    ready: Ready
    milliseconds: float = 0.0

    async def before_first_start(self) -> None:
        await self.ready.before_first_start()

    async def wait(self, pid: int) -> None:
        await self.ready.wait(pid)
        self.milliseconds = used(pid)


async def open_office() -> dict[str, float]:
    """Processor milliseconds of each process of an office until it is ready."""
    bus = BusOptions(connect=f"tcp/127.0.0.1:{free_port()}")
    meters = {}
    with tempfile.TemporaryDirectory() as data:
        specs = []
        for spec in office_specs(OfficeOptions(data=Path(data), log_level="error"), bus):
            assert spec.ready is not None
            meters[spec.name] = Metered(spec.ready)
            specs.append(dataclasses.replace(spec, ready=meters[spec.name]))
        async with Launcher(specs, bus):
            return {f"{name}, until ready": one.milliseconds for name, one in meters.items()}


def rounds(count: int) -> Iterator[dict[str, float]]:
    for _ in range(count):
        yield {name: run_once(arguments) for name, arguments in COMMANDS.items()}
        yield asyncio.run(open_office())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    least: dict[str, float] = {}
    for figures in rounds(parser.parse_args().rounds):
        least |= {name: min(one, least.get(name, one)) for name, one in figures.items()}
    print("| what | processor ms |\n|------|---:|")
    for name, figure in least.items():
        print(f"| {name} | {figure:.0f} |")


if __name__ == "__main__":
    main()
