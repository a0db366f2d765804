"""Many modules on one bus: how long until all are known, and what a query costs then.

``uv run python bench/registrations.py [--modules N] [--processes N]``

Starts a router, central and so many modules in a few processes. Prints a Markdown table: seconds
until a watcher sees all, until central has been introduced to all (each answers a command), and
the median time of a query before and after.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import resource
import statistics
import sys
import time
from pathlib import Path

import uvloop

from tca_bus import BusOptions, Command, Module, Query, Router, TaskContext
from tca_bus.testing import central, eventually

QUERIES = 200
PATIENCE = 600.0


class Echo(Query[int]):
    """Give the number back."""

    number: int


def command_type(number: int) -> type[Command[int]]:
    """A command that one module alone handles."""
    return type(f"Work{number}", (Command[int],), {"__module__": __name__})


async def many(endpoint: str, first: int, count: int) -> None:
    """Run modules in this process, a dozen entering at a time."""
    options = BusOptions(connect=endpoint, realm="bench", connect_timeout=PATIENCE)
    entering = asyncio.Semaphore(12)

    async def run_one(number: int) -> None:
        module = Module(f"module-{number}", options=options)

        @module.handler(command_type(number))
        async def work(_message: Command[int], _: TaskContext) -> int:
            return number

        async with contextlib.AsyncExitStack() as stack:
            async with entering:
                await stack.enter_async_context(module)
            await module.serve_forever()

    async with asyncio.TaskGroup() as group:
        for number in range(first, first + count):
            group.create_task(run_one(number))


async def run(modules: int, processes: int) -> None:
    """Measure."""
    async with contextlib.AsyncExitStack() as stack:
        router = await stack.enter_async_context(Router("tcp/127.0.0.1:0"))
        options = BusOptions(connect=router.endpoint, realm="bench")
        await stack.enter_async_context(central(options))
        server = Module("server", options=options)

        @server.handler(Echo)
        async def echo(message: Echo, _: object) -> int:
            return message.number

        await stack.enter_async_context(server)
        watcher = await stack.enter_async_context(Module("watcher", options=options))
        await watcher.wait_for(Echo, "tca.submit", timeout=30.0)
        before = await query_time(watcher)
        begun = time.perf_counter()
        share = -(-modules // processes)
        for first in range(0, modules, share):
            count = min(share, modules - first)
            await stack.enter_async_context(_process(options.connect, first, count))
        known = modules + len(watcher.modules())
        await eventually(lambda: len(watcher.modules()) >= known, timeout=PATIENCE)
        seen = time.perf_counter() - begun
        await _all_work(watcher, modules)
        served = time.perf_counter() - begun
        after = await query_time(watcher)
    print("| modules | all seen s | all served s | query µs before | after | ratio |")
    print("|--------:|-----------:|-------------:|----------------:|------:|------:|")
    figures = f"{seen:.1f} | {served:.1f} | {before:,.0f} | {after:,.0f} | {after / before:.2f}"
    print(f"| {modules:,} | {figures} |")


async def _all_work(watcher: Module, modules: int) -> None:
    """Have every module carry out a command, a few at a time."""
    few = asyncio.Semaphore(20)

    async def one(number: int) -> None:
        async with few:
            handle = await watcher.execute(
                command_type(number)(), wait_for_handler=PATIENCE, timeout=PATIENCE
            )
            assert await handle.result(timeout=PATIENCE) == number

    async with asyncio.TaskGroup() as group:
        for number in range(modules):
            group.create_task(one(number))


async def query_time(module: Module) -> float:
    """The median µs of a query."""
    times = []
    for number in range(QUERIES):
        begun = time.perf_counter()
        await module.query(Echo(number=number), timeout=PATIENCE)
        times.append((time.perf_counter() - begun) * 1e6)
    return statistics.median(times)


@contextlib.asynccontextmanager
async def _process(endpoint: str, first: int, count: int):  # noqa: ANN202
    arguments = [str(Path(__file__)), "--many", endpoint, str(first), str(count)]
    child = await asyncio.create_subprocess_exec(sys.executable, *arguments)
    try:
        yield child
    finally:
        if child.returncode is None:
            child.kill()
        await child.wait()


def main() -> None:
    """Read the command line and run one of the roles."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--modules", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=4)
    parser.add_argument("--many", nargs=3, help=argparse.SUPPRESS)
    flags = parser.parse_args()
    # A module has a socket and some threads, each with its own pipe.
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    if flags.many:
        endpoint, first, count = flags.many
        uvloop.run(many(endpoint, int(first), int(count)))
    else:
        uvloop.run(run(flags.modules, flags.processes))


if __name__ == "__main__":
    main()
