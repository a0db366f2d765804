"""How far one slow module of a pool holds up queries that another could take.

``uv run python bench/pools.py`` prints, for each pool, the wall milliseconds from sending a query
to its answer: median, 99th percentile and longest.
"""

from __future__ import annotations

import asyncio
import statistics
import time
from contextlib import AsyncExitStack

from tca_bus import BusOptions, Module, Query
from tca_bus.testing import bus, eventually

QUERIES = 400
AT_ONCE = 8
SLOW = 2.0
QUICK = 0.001


class Plan(Query[str]):
    number: int


def server(name: str, options: BusOptions, seconds: float, capacity: int | None) -> Module:
    module = Module(name, options=options)

    async def plan(_message: Plan, _context: object) -> str:
        await asyncio.sleep(seconds)
        return name

    module.serve(Plan, plan, capacity=capacity)
    return module


async def measure(asker: Module) -> list[float]:
    gate = asyncio.Semaphore(AT_ONCE)
    taken: list[float] = []

    async def ask(number: int) -> None:
        async with gate:
            began = time.perf_counter()
            await asker.query(Plan(number=number), timeout=120.0)
            taken.append((time.perf_counter() - began) * 1e3)

    await asyncio.gather(*(ask(number) for number in range(QUERIES)))
    return sorted(taken)


async def run(title: str, pool: dict[str, float], capacity: int | None) -> None:
    async with bus() as options, AsyncExitStack() as stack:
        for name, seconds in pool.items():
            await stack.enter_async_context(server(name, options, seconds, capacity))
        asker = await stack.enter_async_context(Module("asker", options=options))
        await eventually(lambda: len(asker.modules()) > len(pool))
        began = time.perf_counter()
        taken = await measure(asker)
        seconds = time.perf_counter() - began
    late = sum(one > SLOW * 500 for one in taken)
    print(
        f"{title:34} {statistics.median(taken):8.1f} {taken[-len(taken) // 100]:8.1f} "
        f"{taken[-1]:8.1f} {late:6} {seconds:8.1f}"
    )


async def main() -> None:
    print(f"{'pool':34} {'p50 ms':>8} {'p99 ms':>8} {'max ms':>8} {'slow':>6} {'total s':>8}")
    await run("quick alone, capacity 1", {"b": QUICK}, 1)
    await run("slow and quick, capacity 1", {"a": SLOW, "b": QUICK}, 1)
    await run("two quick, capacity 1", {"a": QUICK, "b": QUICK}, 1)
    await run("two quick, no capacity", {"a": QUICK, "b": QUICK}, None)


if __name__ == "__main__":
    asyncio.run(main())
