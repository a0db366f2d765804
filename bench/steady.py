"""A day of steady traffic in minutes, with the memory of each process watched.

    uv run python bench/steady.py                  24 simulated hours
    uv run python bench/steady.py --hours 2        the short form

Router, central and three modules run as processes; this one sends. A simulated hour is as many
messages as an hour has at the stated rates, sent as fast as they are answered: goals of three
commands each, commands, some of which fail, queries and informs. After each hour the resident
memory of every process is noted. Prints first, last and slope; ends with 1 if what a process has in
the last quarter is more than 5 % above what it had in the second, which is after all bounded
histories are full.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import socket
import statistics
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from pathlib import Path

from tca_bus import (
    BusOptions,
    Command,
    Constraint,
    Context,
    Goal,
    Inform,
    Module,
    Query,
    TaskContext,
    TaskError,
    TaskFailedError,
)
from tca_bus.launcher import Launcher, ModulePresent, ProcessSpec, RouterListening

PAGE = os.sysconf("SC_PAGE_SIZE")
WORKERS = ("worker-0", "worker-1", "worker-2")
AT_ONCE = 32
GROWTH = 1.05
PATIENCE = 60.0
FAILURES = 50
"""Every so many commands one fails."""


class Lift(Command[int]):
    number: int


class Fetch(Goal[int]):
    number: int


class Where(Query[str]):
    asked: int


class Ring(Inform):
    times: int


@dataclass(frozen=True)
class Rates:
    """Messages per simulated hour."""

    goals: int
    commands: int
    queries: int
    informs: int


async def serve(name: str) -> None:
    """Be one of the modules."""
    options = BusOptions(connect=os.environ["TCA_CONNECT"], realm=os.environ["TCA_REALM"])
    module = Module(name, options=options)

    async def lift(message: Lift, _: Context) -> int:
        if message.number % FAILURES == 0:
            raise TaskError("dropped", f"number {message.number} is dropped", data={"from": 1})
        return message.number

    async def fetch(_: Fetch, context: TaskContext) -> int:
        lifts = [await context.execute(Lift(number=1)) for _ in range(3)]
        return sum([await one.result() for one in lifts])

    async def where(_: Where, __: Context) -> str:
        return "r-5303"

    async def ring(_: Ring, __: Context) -> None:
        """Do nothing."""

    module.serve(Lift, lift, capacity=8)
    module.serve(Fetch, fetch, capacity=8)
    module.serve(Where, where)
    module.serve(Ring, ring)
    async with module:
        await module.serve_forever()


@dataclass
class Day:
    """The traffic of one run and the memory that it took, in MB per process and hour."""

    launcher: Launcher
    sender: Module
    memory: dict[str, list[float]] = field(default_factory=dict)
    sent: int = 0

    async def hour(self, rates: Rates) -> None:
        """Send one simulated hour's messages."""
        await self._many(rates.goals, self._goal)
        await self._many(rates.commands, self._command)
        await self._many(rates.queries, self._query)
        for _ in range(rates.informs):
            await self.sender.inform(Ring(times=1))

    def sample(self) -> None:
        """Note the memory of every process."""
        pids = {name: self.launcher.pid(name) for name in ("router", "central", *WORKERS)}
        for name, pid in {**pids, "sender": os.getpid()}.items():
            pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
            self.memory.setdefault(name, []).append(pages * PAGE / 1e6)

    async def _many(self, count: int, send: Callable[[int], Awaitable[None]]) -> None:
        numbers = iter(range(count))

        async def one_after_the_other() -> None:
            for number in numbers:
                await send(number)
                self.sent += 1

        async with asyncio.TaskGroup() as group:
            for _ in range(AT_ONCE):
                group.create_task(one_after_the_other())

    async def _goal(self, number: int) -> None:
        goal = await self.sender.expand(Fetch(number=number), constraints=Constraint.NONE)
        assert await goal.result(timeout=PATIENCE) == 3

    async def _command(self, number: int) -> None:
        command = await self.sender.execute(Lift(number=number), constraints=Constraint.NONE)
        try:
            await command.result(timeout=PATIENCE)
        except TaskFailedError as error:
            if error.failure.name != "dropped":
                raise

    async def _query(self, number: int) -> None:
        assert await self.sender.query(Where(asked=number)) == "r-5303"


def specs(options: BusOptions, data: Path) -> list[ProcessSpec]:
    tca = (sys.executable, "-m", "tca_bus")
    worker = (sys.executable, str(Path(__file__)), "--serve")
    return [
        ProcessSpec("router", (*tca, "router"), ready=RouterListening(options), restart=None),
        ProcessSpec(
            "central",
            (*tca, "central", "--data", str(data)),
            ready=ModulePresent("central", options),
            restart=None,
        ),
        *(
            ProcessSpec(name, (*worker, name), ready=ModulePresent(name, options), restart=None)
            for name in WORKERS
        ),
    ]


async def run(hours: int, rates: Rates) -> Day:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    options = BusOptions(connect=endpoint, realm="steady")
    with tempfile.TemporaryDirectory() as data:
        async with (
            Launcher(specs(options, Path(data)), options) as launcher,
            Module("sender", options=options) as sender,
        ):
            await sender.wait_for(Lift, Fetch, Where, Ring, "tca.submit", timeout=PATIENCE)
            day = Day(launcher, sender)
            for hour in range(hours):
                await day.hour(rates)
                day.sample()
                print(f"{hour + 1} h, central {day.memory['central'][-1]:.1f} MB", file=sys.stderr)
            journal = os.stat(f"{data}/central.db").st_size / 1e6  # noqa: PTH116
    print(f"the journal has {journal:.0f} MB")
    return day


def report(day: Day) -> bool:
    """Print the memory of each process; whether none grew."""
    steady = True
    print(f"{'process':10} {'first MB':>9} {'last MB':>9} {'MB/hour':>9}")
    for name, values in day.memory.items():
        quarter = max(1, len(values) // 4)
        second, last = values[quarter : 2 * quarter] or values, values[-quarter:]
        grew = statistics.mean(last) > GROWTH * statistics.mean(second)
        steady = steady and not grew
        # The slope of what comes after the first quarter, in which histories fill.
        hours = range(len(values) - quarter)
        late = values[quarter:]
        slope = statistics.linear_regression(hours, late).slope if len(late) > 1 else 0.0
        mark = "  grows" if grew else ""
        print(f"{name:10} {values[0]:9.1f} {values[-1]:9.1f} {slope:9.3f}{mark}")
    return steady


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hours", type=int, default=24, help="simulated hours")
    parser.add_argument("--goals", type=int, default=120, help="goals an hour, of 3 commands each")
    parser.add_argument("--commands", type=int, default=360, help="commands an hour")
    parser.add_argument("--queries", type=int, default=3600, help="queries an hour")
    parser.add_argument("--informs", type=int, default=3600, help="informs an hour")
    parser.add_argument("--serve", metavar="NAME", help=argparse.SUPPRESS)
    flags = parser.parse_args()
    if flags.serve:
        asyncio.run(serve(flags.serve))
        return 0
    rates = Rates(flags.goals, flags.commands, flags.queries, flags.informs)
    begun = time.monotonic()
    day = asyncio.run(run(flags.hours, rates))
    seconds = time.monotonic() - begun
    print(f"{flags.hours} simulated hours, {day.sent} tasks and queries, in {seconds:.0f} s")
    return 0 if report(day) else 1


if __name__ == "__main__":
    sys.exit(main())
