"""A whole office for tests: real processes on a free port, in lockstep."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from rogue.cli._trace import followed
from rogue.messages import TraceLine
from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions, Module
from tca_bus.launcher import Launcher, free_port
from xavier_sim.messages import ItemMoved

EPOCH = "1996-03-04T09:00:00"


@dataclass
class Office:
    """A running office, seen from the outside."""

    bus: BusOptions
    launcher: Launcher
    module: Module
    lines: list[TraceLine] = field(default_factory=list)
    moved: list[ItemMoved] = field(default_factory=list)
    changed: asyncio.Condition = field(default_factory=asyncio.Condition)

    async def command(self, *words: str) -> tuple[int, str, str]:
        """Run one of the command lines as a user does: exit code, output, errors."""
        process = await self.start_command(*words)
        out, err = await process.communicate()
        return process.returncode or 0, out.decode(), err.decode()

    async def start_command(self, *words: str) -> asyncio.subprocess.Process:
        """Begin one of the command lines."""
        environment = {
            **os.environ,
            "TCA_CONNECT": self.bus.connect,
            "TCA_REALM": self.bus.realm,
        }
        return await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            *words,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env=environment,
        )

    async def request(self, item: str, user: str, *words: str) -> asyncio.subprocess.Process:
        """Begin ``rogue request ... --wait``."""
        return await self.start_command("rogue", "request", item, "--user", user, "--wait", *words)

    async def line(self, wanted: Callable[[str], bool], *, after: int = 0) -> TraceLine:
        """The first line after number ``after`` that is ``wanted``, once it is there."""
        async with self.changed:
            await self.changed.wait_for(lambda: _find(self.lines, wanted, after) is not None)
            found = _find(self.lines, wanted, after)
            assert found is not None
            return found

    async def requests(self) -> list[dict[str, object]]:
        """What ``rogue requests --json`` lists."""
        code, out, err = await self.command("rogue", "requests", "--json")
        assert code == 0, err
        found: list[dict[str, object]] = json.loads(out)
        return found

    def kill(self, name: str) -> None:
        """Kill a process of the office as hard as can be."""
        pid = self.launcher.pid(name)
        assert pid is not None
        os.kill(pid, signal.SIGKILL)

    @property
    def last(self) -> int:
        """Number of the last line so far."""
        return self.lines[-1].seq if self.lines else 0


def _find(lines: list[TraceLine], wanted: Callable[[str], bool], after: int) -> TraceLine | None:
    return next((line for line in lines if line.seq > after and wanted(line.text)), None)


@asynccontextmanager
async def office(folder: Path, **options: object) -> AsyncIterator[Office]:
    """Run an office on a free port; ``options`` are those of `OfficeOptions`."""
    bus = BusOptions(connect=f"tcp/127.0.0.1:{free_port()}", realm="test", clock="sim")
    values = {"data": folder, "speed": "max", "silence": 0.0, "epoch": EPOCH, **options}
    specs = office_specs(OfficeOptions(**values), bus)
    async with (
        Launcher(specs, bus, log_dir=folder / "logs") as launcher,
        Module(f"test-{os.getpid()}", options=bus) as module,
    ):
        running = Office(bus, launcher, module)
        async with module.subscribe(ItemMoved) as moved:
            watchers = [
                asyncio.create_task(_read(running), name="read trace"),
                asyncio.create_task(_collect(moved, running), name="watch items"),
            ]
            try:
                await running.line(lambda text: text.startswith("Listening"))
                yield running
            finally:
                for watcher in watchers:
                    watcher.cancel()
                await asyncio.gather(*watchers, return_exceptions=True)


async def _read(running: Office) -> None:
    async for line in followed(running.module):
        async with running.changed:
            running.lines.append(line)
            running.changed.notify_all()


async def _collect(moved: AsyncIterator[ItemMoved], running: Office) -> None:
    async for one in moved:
        running.moved.append(one)
