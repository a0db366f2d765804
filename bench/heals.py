"""How long until every module on both sides of a healed link knows again who is there.

    uv run python bench/heals.py --heals 20 --cuts 1 3 10 --how down unplugged silent

Two network namespaces with a router and modules each; the far router is linked to the near one,
or, with ``--by modules``, there is none and the far modules go to the near router themselves.
The link is cut, and healed after so many seconds and up to one more. Times are wall seconds from
the first answer of an independent UDP probe, one packet each 10 ms, to the moment from which on
all tables are right: they name all modules of both sides, and doubt none. ``switched``: the same
from the return of the command that heals. A table that was never wrong counts as 0. Needs Linux,
``ip`` and root.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import random
import socket
import statistics
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path

from tca_bus import BusOptions, Module
from tca_bus.testing import eventually

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "links"))
from links_namespaces import FAR_ADDRESS, NEAR_ADDRESS, Cable, Cut, cable

HERE = "tcp/127.0.0.1:7447"
REALM = "heals"
LOOK = 0.005
"""Wall seconds between two looks at the tables of one side."""
STEADY = 2.5
"""Wall seconds for which all must have been right: longer than a link's lease."""
PATIENCE = 60.0
ECHO_PORT = 7448


class Side:
    """What one process says of its modules' tables, as of when."""

    def __init__(self) -> None:
        self.is_right = False
        self.since = time.monotonic()
        self.was_wrong = True

    async def follow(self, lines: asyncio.StreamReader) -> None:
        """Read what it says, until it ends."""
        async for line in lines:
            said = json.loads(line)
            self.is_right, self.since = said["right"], said["time"]
            self.was_wrong |= not self.is_right

    def has_settled(self) -> bool:
        return self.is_right and time.monotonic() - self.since > STEADY


class Probe:
    """When the last answer came from the far side, and the first one since it was reset."""

    def __init__(self) -> None:
        self.first = 0.0

    async def follow(self, lines: asyncio.StreamReader) -> None:
        async for line in lines:
            self.first = self.first or float(line)


async def crowd(side: str, endpoint: str, count: int) -> None:
    """Be the modules of one side, and print each change of whether all their tables are right."""
    options = BusOptions(connect=endpoint, realm=REALM, connect_timeout=PATIENCE)
    async with contextlib.AsyncExitStack() as stack:
        modules = [
            await stack.enter_async_context(Module(f"{side}-{number}", options=options))
            for number in range(count)
        ]
        was_right: bool | None = None
        while True:
            is_right = all(_is_right(module, 2 * count) for module in modules)
            if is_right != was_right:
                print(json.dumps({"time": time.monotonic(), "right": is_right}), flush=True)
                was_right = is_right
            await asyncio.sleep(LOOK)


def _is_right(watcher: Module, everybody: int) -> bool:
    table = watcher.core.presence.table
    present = watcher.modules()
    return len(present) == everybody and all(table.state_of(one.incarnation) for one in present)


def echo() -> None:
    """Answer the probe."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as answering:
        answering.bind((FAR_ADDRESS, ECHO_PORT))
        while True:
            data, sender = answering.recvfrom(64)
            with contextlib.suppress(OSError):
                answering.sendto(data, sender)


def probe() -> None:
    """Ask each 10 ms; print when an answer to that very question came."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.settimeout(0.01)
        while True:
            asked = time.monotonic()
            with contextlib.suppress(OSError):
                asking.sendto(repr(asked).encode(), (FAR_ADDRESS, ECHO_PORT))
                # An answer that came late would else be taken for that of the next question.
                while asking.recv(64) != repr(asked).encode():
                    pass
                print(time.monotonic(), flush=True)
            time.sleep(max(0.0, asked + 0.01 - time.monotonic()))


class Bench:
    """The processes on both sides of a link."""

    def __init__(self, link: Cable, sides: list[Side], seen: Probe) -> None:
        self._link = link
        self._sides = sides
        self._seen = seen

    async def settled(self) -> None:
        """Wait until all tables have been right for a while."""
        await eventually(lambda: all(side.has_settled() for side in self._sides), timeout=PATIENCE)

    async def heal_after(self, seconds: float, how: Cut) -> tuple[float, float]:
        """Cut and heal; gives the seconds from the first answered probe, and from the command."""
        await self.settled()
        for side in self._sides:
            side.was_wrong = False
        self._link.cut(how)
        await asyncio.sleep(seconds)
        self._seen.first = 0.0
        self._link.heal(how)
        healed = time.monotonic()
        await eventually(lambda: self._seen.first > 0, timeout=PATIENCE)
        # A short cut is noticed after its end, if at all.
        await asyncio.sleep(STEADY)
        await self.settled()
        right = max((side.since for side in self._sides if side.was_wrong), default=0.0)
        return max(0.0, right - self._seen.first), max(0.0, right - healed)


@contextlib.asynccontextmanager
async def office(link: Cable, count: int, by: str) -> AsyncIterator[Bench]:
    """Routers, modules and probe on both sides."""
    async with contextlib.AsyncExitStack() as stack:
        group = await stack.enter_async_context(asyncio.TaskGroup())

        async def spawn(side: str, *command: str) -> asyncio.subprocess.Process:
            argv = link.inside(side, sys.executable, *command)
            pipe = asyncio.subprocess.PIPE
            env = {**os.environ, "TCA_REALM": REALM}
            process = await asyncio.create_subprocess_exec(*argv, stdout=pipe, env=env)
            stack.push_async_callback(_end, process)
            return process

        everywhere = ("-m", "tca_bus", "router", "--connect", "tcp/0.0.0.0:7447")
        await spawn("near", *everywhere)
        across = f"tcp/{NEAR_ADDRESS}:7447"
        if by == "routers":
            await spawn("far", *everywhere, "--link", across)
        endpoints = {"near": HERE, "far": HERE if by == "routers" else across}
        sides = [Side(), Side()]
        for (name, endpoint), side in zip(endpoints.items(), sides, strict=True):
            process = await spawn(name, __file__, "--crowd", name, endpoint, str(count))
            assert process.stdout is not None
            group.create_task(side.follow(process.stdout))
        await spawn("far", __file__, "--echo")
        asking, seen = await spawn("near", __file__, "--probe"), Probe()
        assert asking.stdout is not None
        group.create_task(seen.follow(asking.stdout))
        yield Bench(link, sides, seen)


async def _end(process: asyncio.subprocess.Process) -> None:
    if process.returncode is None:
        process.kill()
    await process.wait()


async def measure(flags: argparse.Namespace) -> None:
    chance = random.Random(flags.seed)
    with cable() as link:
        async with office(link, flags.modules, flags.by) as bench:
            print(f"{flags.modules} modules on each side, {flags.heals} heals each; wall seconds")
            for how in flags.how:
                for cut in flags.cuts:
                    # Where in everybody's retries the heal falls is left to chance.
                    lengths = [cut + chance.random() for _ in range(flags.heals)]
                    found = [await bench.heal_after(length, how) for length in lengths]
                    _tell(f"{how}, {cut:g} to {cut + 1:g} s", found)


def _tell(what: str, found: list[tuple[float, float]]) -> None:
    seen, switched = ([times[place] for times in found] for place in (0, 1))
    print(
        f"{what:24} median {statistics.median(seen):.2f}  worst {max(seen):.2f}"
        f"  switched: median {statistics.median(switched):.2f}  worst {max(switched):.2f}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--modules", type=int, default=5, help="on each side")
    parser.add_argument("--heals", type=int, default=20)
    parser.add_argument("--cuts", type=float, nargs="+", default=[1.0, 3.0, 10.0])
    ways = ("down", "unplugged", "silent")
    parser.add_argument("--how", nargs="+", choices=ways, default=list(ways))
    parser.add_argument("--by", choices=("routers", "modules"), default="routers")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--crowd", nargs=3, help=argparse.SUPPRESS)
    parser.add_argument("--echo", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--probe", action="store_true", help=argparse.SUPPRESS)
    flags = parser.parse_args()
    if flags.crowd:
        side, endpoint, count = flags.crowd
        asyncio.run(crowd(side, endpoint, int(count)))
    elif flags.echo:
        echo()
    elif flags.probe:
        probe()
    else:
        asyncio.run(measure(flags))


if __name__ == "__main__":
    main()
