"""Measuring: every contender does the same, in turn."""

from __future__ import annotations

import asyncio
import itertools
import time
from collections import defaultdict
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

from contenders.base import Client, Contender, Received, stamped

AT_ONCE = 100
"""Calls under way at a time, where it is not one."""

PACE = 0.002
"""Seconds between one-way messages whose delay is measured."""

BURST = 64
"""One-way messages after which a flooding sender lets its loop turn."""

SETTLED = 0.3
"""Seconds without an arrival after which a flood is over."""

Text = Callable[[], str]


@dataclass(frozen=True)
class Plan:
    """How much is measured: rounds, calls one at a time in each, and payloads in bytes."""

    rounds: int
    calls: int
    sizes: tuple[int, ...]


@dataclass
class Series:
    """What was seen of one thing: µs of each, things per second of each round, parts lost."""

    times: list[float] = field(default_factory=list)
    rates: list[float] = field(default_factory=list)
    lost: list[float] = field(default_factory=list)


Samples = dict[tuple[str, str, int], Series]
"""By what was done, by whom (the title), and the payload's size."""


async def measure(clients: dict[Contender, Client], plan: Plan) -> Samples:
    """Measure everything, after a round that does not count."""
    warm_up = Plan(1, max(5, plan.calls // 10), plan.sizes)
    await _rounds(clients, warm_up)
    return await _rounds(clients, plan)


async def _rounds(clients: dict[Contender, Client], plan: Plan) -> Samples:
    samples: Samples = defaultdict(Series)
    order = list(clients.items())
    for number, size in itertools.product(range(plan.rounds), plan.sizes):
        # Nobody always comes after the same neighbour's leftovers.
        turn = number % len(order)
        for contender, client in order[turn:] + order[:turn]:
            async for what, series in _turn(client, plan.calls, size):
                mine = samples[what, contender.title, size]
                mine.times += series.times
                mine.rates += series.rates
                mine.lost += series.lost
    return samples


async def _turn(client: Client, calls: int, size: int) -> AsyncIterator[tuple[str, Series]]:
    """One contender's turn of a round."""

    def text() -> str:
        return stamped(size)

    yield "query", await one_at_a_time(client.ask, text, calls)
    yield "queries", await many_at_once(client.ask, text, calls * 5)
    yield "inform", await paced(client, text, calls // 2)
    many = calls * (20 if size < 10_000 else 5)
    yield "informs", await flood(client, text, many)
    if hasattr(client, "tell_many"):
        yield "together", await flood_together(client, text, many)
    if hasattr(client, "command"):
        async for what, series in _tasks(client, text, calls):
            yield what, series


async def _tasks(client: Any, text: Text, calls: int) -> AsyncIterator[tuple[str, Series]]:
    yield "command", await one_at_a_time(client.command, text, max(3, calls // 5))
    yield "commands", await many_at_once(client.command, text, calls)
    yield "goal", await one_at_a_time(client.goal, text, max(2, calls // 20))


async def one_at_a_time(call: Callable[[str], Awaitable[object]], text: Text, count: int) -> Series:
    """Call after call."""
    times = [await _timed(call, text()) for _ in range(count)]
    return Series(times, [count / sum(times) * 1e6])


async def many_at_once(call: Callable[[str], Awaitable[object]], text: Text, count: int) -> Series:
    """A hundred callers, each with one call at a time."""
    times: list[float] = []
    left = iter(range(count))

    async def caller() -> None:
        times.extend([await _timed(call, text()) for _ in left])

    begun = time.perf_counter()
    await asyncio.gather(*(caller() for _ in range(AT_ONCE)))
    return Series(times, [count / (time.perf_counter() - begun)])


async def paced(client: Client, text: Text, count: int) -> Series:
    """One-way messages at a steady pace; what counts is their delay."""
    await client.forget()
    for _ in range(count):
        await client.tell(text())
        await asyncio.sleep(PACE)
    return Series((await _arrived(client, count)).delays)


async def flood(client: Client, text: Text, count: int) -> Series:
    """One-way messages as fast as they go; what counts is how fast they arrive."""
    await client.forget()
    message = text()
    for number in range(count):
        await client.tell(message)
        if not number % BURST:
            await asyncio.sleep(0)
    return await _flooded(client, count)


async def flood_together(client: Any, text: Text, count: int) -> Series:
    """The same, `BURST` in one message of the transport."""
    await client.forget()
    messages = [text()] * BURST
    for number in range(0, count, BURST):
        await client.tell_many(messages[: count - number])
        await asyncio.sleep(0)
    return await _flooded(client, count)


async def _flooded(client: Client, count: int) -> Series:
    seen = await _arrived(client, count)
    rate = seen.count / seen.seconds if seen.seconds else 0.0
    return Series([], [rate], [1 - seen.count / count])


async def _arrived(client: Client, count: int) -> Received:
    """What arrived, once all did or nothing more does."""
    seen = await client.received()
    while seen.count < count:
        await asyncio.sleep(SETTLED)
        before, seen = seen, await client.received()
        if seen.count == before.count:
            break
    return seen


async def _timed(call: Callable[[str], Awaitable[object]], text: str) -> float:
    begun = time.perf_counter()
    await call(text)
    return (time.perf_counter() - begun) * 1e6
