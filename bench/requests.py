"""Hundreds of open requests: how long posting, listing, showing and cancelling take.

An agent's process on a bus of its own, with a navigator that knows sixty rooms and a robot that
never moves, so that every request stays open. ``uv run python bench/requests.py [COUNT]``
"""

from __future__ import annotations

import argparse
import asyncio
import os
import random
import statistics
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from navigate.messages import PlanRoutes, RoomLocation, Rooms, RouteTable
from rogue.messages import CancelRequest, ListRequests, PostRequest, ShowRequest, Why
from rogue.requests import read_entries
from tca_bus import BusOptions, Context, Module, Query
from tca_bus.testing import bus

COUNT = 300
BATCH = 50
TIMES = 9
PLACES = {
    f"r-5{wing}{number:02d}": (180.0 * number, 1000.0 * wing)
    for wing in (3, 4)
    for number in range(1, 31)
}


async def rooms(message: Rooms, context: Context) -> list[RoomLocation]:
    """Where all rooms are."""
    del message, context
    return [RoomLocation(room=room, x=x, y=y) for room, (x, y) in PLACES.items()]


async def routes(message: PlanRoutes, context: Context) -> RouteTable:
    """How far it is between rooms, along corridors at right angles."""
    del context
    table: list[list[float | None]] = [
        [_metres(start, end) for end in message.rooms] for start in message.rooms
    ]
    return RouteTable(rooms=message.rooms, metres=table, seconds=table, from_here=table[0])


def _metres(start: str, end: str) -> float:
    (x, y), (u, v) = PLACES[start], PLACES[end]
    return (abs(x - u) + abs(y - v)) / 100.0


@asynccontextmanager
async def agent(options: BusOptions, folder: str) -> AsyncIterator[None]:
    """Run the agent's process for as long as the block lasts."""
    environment = {**os.environ, "TCA_CONNECT": options.connect, "TCA_REALM": options.realm}
    words = ("agent", "--data", folder, "--log-level", "error")
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "rogue", *words, env=environment
    )
    try:
        yield
    finally:
        process.terminate()
        await process.wait()


async def post_all(module: Module, count: int) -> None:
    """Post errands between random rooms, one after the other."""
    rng, entries = random.Random(1), read_entries()
    spent: list[float] = []
    for number in range(count):
        pickup, deliver = rng.sample(sorted(PLACES), 2)
        message = PostRequest(
            id=f"q{number}",
            user=rng.choice(sorted(entries.people)),
            item=rng.choice(sorted(entries.items)),
            pickup=pickup,
            deliver=deliver,
        )
        spent.append(await _timed(module, message))
        if len(spent) == BATCH or number == count - 1:
            say(f"post, {number + 1} open", spent)
            spent.clear()


async def _timed(module: Module, query: Query[Any]) -> float:
    begun = time.perf_counter()
    await module.query(query, timeout=60.0)
    return time.perf_counter() - begun


def say(what: str, spent: list[float]) -> None:
    """Print a line of the table, in milliseconds."""
    sys.stdout.write(
        f"{what:24} median {statistics.median(spent) * 1e3:6.1f}  most {max(spent) * 1e3:6.1f} ms\n"
    )
    sys.stdout.flush()


async def main(count: int) -> None:
    """Run the measurement."""
    with tempfile.TemporaryDirectory() as folder:
        async with bus() as options:
            module = Module("user", options=options)
            module.serve(Rooms, rooms)
            module.serve(PlanRoutes, routes)
            async with agent(options, folder), module:
                await module.wait_for(PostRequest, timeout=60.0)
                await post_all(module, count)
                for query in (
                    ListRequests(),
                    ListRequests(most=20),
                    ListRequests(user="jhm"),
                    ShowRequest(id="q1"),
                    Why(id="q1"),
                ):
                    spent = [await _timed(module, query) for _ in range(TIMES)]
                    told = query.model_dump(exclude_defaults=True).items()
                    say(" ".join([query.wire_name, *(f"{k}={v}" for k, v in told)]), spent)
                cancels = [CancelRequest(id=f"q{number}") for number in range(TIMES)]
                say("rogueCancel", [await _timed(module, one) for one in cancels])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=COUNT, help="requests to post")
    asyncio.run(main(max(TIMES, parser.parse_args().count)))
