"""How long until every module knows who is there, after a kill and after a router's restart.

    uv run python bench/presence.py --modules 20 --rounds 5

``killed``: from kill -9 of a module to its loss in the table of every other module.
``router``: from the moment when a restarted router listens until every table is right, that is,
names all modules that are there, and not the one that was killed while the router was away.
Prints the median and the worst of each, in wall seconds.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import os
import signal
import socket
import statistics
import sys
import time
from collections.abc import AsyncIterator

from tca_bus import BusOptions, Module
from tca_bus.launcher import RouterListening
from tca_bus.testing import eventually

VICTIM = """
import asyncio, sys
from tca_bus import BusOptions, Module
async def main(endpoint):
    async with Module("victim", options=BusOptions(connect=endpoint, realm="presence")) as module:
        await module.serve_forever()
asyncio.run(main(sys.argv[1]))
"""

PATIENCE = 30.0


class Bench:
    """Modules in this process, each with a session of its own; router and victim beside it."""

    def __init__(self, options: BusOptions, watchers: list[Module]) -> None:
        self.options = options
        self.watchers = watchers

    async def victim(self) -> asyncio.subprocess.Process:
        """Start a module to be killed, and wait until all others see it."""
        process = await spawn("-c", VICTIM, self.options.connect)
        await eventually(lambda: self._everybody_sees(process.pid), timeout=PATIENCE)
        return process

    async def killed(self) -> float:
        """Kill a module; gives the seconds until nobody takes it for present."""
        process = await self.victim()
        begun = time.monotonic()
        await kill(process)
        await eventually(lambda: self._nobody_sees(process.pid), timeout=PATIENCE)
        return time.monotonic() - begun

    async def restarted(
        self, router: asyncio.subprocess.Process
    ) -> tuple[float, asyncio.subprocess.Process]:
        """Restart the router with one module fewer; gives the seconds until all know it."""
        process = await self.victim()
        await kill(router)
        await kill(process)
        again = await start_router(self.options)
        begun = time.monotonic()
        await eventually(lambda: self._is_right(process.pid), timeout=PATIENCE)
        return time.monotonic() - begun, again

    def _everybody_sees(self, pid: int) -> bool:
        return all(pid in _present(watcher) for watcher in self.watchers)

    def _nobody_sees(self, pid: int) -> bool:
        return not any(pid in _present(watcher) for watcher in self.watchers)

    def _is_right(self, lost: int) -> bool:
        return self._nobody_sees(lost) and all(
            len(_present(watcher)) == len(self.watchers) and _is_certain(watcher)
            for watcher in self.watchers
        )


def _present(watcher: Module) -> list[int]:
    return [module.pid for module in watcher.modules()]


def _is_certain(watcher: Module) -> bool:
    """Whether it takes nobody for perhaps gone."""
    table = watcher._parts.core.presence.table  # noqa: SLF001 - no part of the public face
    return all(table.state_of(module.incarnation) for module in watcher.modules())


async def spawn(*arguments: str) -> asyncio.subprocess.Process:
    return await asyncio.create_subprocess_exec(sys.executable, *arguments)


async def kill(process: asyncio.subprocess.Process) -> None:
    os.kill(process.pid, signal.SIGKILL)
    await process.wait()


async def start_router(options: BusOptions) -> asyncio.subprocess.Process:
    router = await spawn("-m", "tca_bus", "router", "--connect", options.connect)
    await RouterListening(options).wait(router.pid)
    return router


@contextlib.asynccontextmanager
async def modules(options: BusOptions, count: int) -> AsyncIterator[list[Module]]:
    async with contextlib.AsyncExitStack() as stack:
        yield [
            await stack.enter_async_context(Module(f"watcher-{number}", options=options))
            for number in range(count)
        ]


async def measure(*, count: int, rounds: int) -> dict[str, list[float]]:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    options = BusOptions(connect=endpoint, realm="presence")
    router = await start_router(options)
    found: dict[str, list[float]] = {"killed": [], "router": []}
    try:
        async with modules(options, count) as watchers:
            bench = Bench(options, watchers)
            for _ in range(rounds):
                found["killed"].append(await bench.killed())
                seconds, router = await bench.restarted(router)
                found["router"].append(seconds)
    finally:
        await kill(router)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--modules", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=5)
    flags = parser.parse_args()
    found = asyncio.run(measure(count=flags.modules, rounds=flags.rounds))
    print(
        f"{flags.modules} modules, {flags.rounds} rounds; wall seconds until all tables are right"
    )
    for name, seconds in found.items():
        print(f"{name}  median {statistics.median(seconds):.2f}  worst {max(seconds):.2f}")


if __name__ == "__main__":
    main()
