"""Round trips on our bus beside bare Zenoh, in one run.

``uv run python bench/bus.py [--rounds N] [--calls N]`` starts a router, central and an answering
process, and asks in turn: bare Zenoh bridged to asyncio (raw bytes, the same bridge), a query
(validated, with envelope, presence and errors), and a command (acknowledged, journaled, handled
and reported through central). The variants are interleaved, so that a busy machine is equally
bad for all; what counts are the ratios.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import statistics
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import zenoh
from rich.console import Console
from rich.table import Table
from zenoh.handlers import Callback

from tca_bus import BusOptions, Command, Module, Query, Router
from tca_bus._bridge import Mailbox, ask
from tca_bus._session import client_config
from tca_bus._wire import Payload

REALM = "bench"
BARE_KEY = "bench-bare/echo"
PAYLOAD = Payload(b"x" * 64, "zenoh/bytes")
START_TIMEOUT = 30.0

Call = Callable[[], Awaitable[object]]


class Echo(Query[str]):
    """Give the text back."""

    text: str


class Carry(Command[str]):
    """Give the text back, as a task."""

    text: str


async def route(endpoint: str) -> None:
    """Be the router."""
    async with Router(endpoint):
        await asyncio.get_running_loop().create_future()


async def answer(endpoint: str) -> None:
    """Be the callee of all variants."""
    options = BusOptions(connect=endpoint, realm=REALM, connect_timeout=START_TIMEOUT)
    module = Module("callee", options=options)

    async def give_back(message: Echo | Carry, context: object) -> str:
        del context
        return message.text

    module.serve(Echo, give_back)
    module.serve(Carry, give_back)
    session = await asyncio.to_thread(zenoh.open, client_config(options))
    try:
        box = Mailbox[zenoh.Query](_reply_bare, size=1024)
        session.declare_queryable(BARE_KEY, Callback(box.post))
        async with module:
            await module.serve_forever()
    finally:
        session.close()


def _reply_bare(query: zenoh.Query) -> None:
    with query:
        query.reply(BARE_KEY, PAYLOAD.data)


@contextlib.asynccontextmanager
async def process(*arguments: str) -> AsyncIterator[None]:
    """Run a process of the bench; it is stopped at the end."""
    child = await asyncio.create_subprocess_exec(sys.executable, *arguments)
    try:
        yield
    finally:
        if child.returncode is None:
            child.terminate()
        await child.wait()


async def free_endpoint() -> str:
    """An endpoint on which nothing listens."""
    async with Router("tcp/127.0.0.1:0") as router:
        return router.endpoint


async def measure(calls: dict[str, Call], *, rounds: int, each: int) -> dict[str, list[float]]:
    """Microseconds of every call, the variants in turn."""
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            for _ in range(each):
                begun = time.perf_counter()
                await call()
                times[name].append((time.perf_counter() - begun) * 1e6)
    return times


def table(times: dict[str, list[float]]) -> Table:
    """Medians and 99th percentiles, absolute and as ratios to the first variant."""
    result = Table(title="round trip on one host through the router")
    for heading in ("variant", "calls", "median µs", "ratio", "p99 µs", "ratio"):
        result.add_column(heading, justify="left" if heading == "variant" else "right")
    base = next(iter(times.values()))
    for name, values in times.items():
        result.add_row(
            name,
            str(len(values)),
            f"{statistics.median(values):.0f}",
            f"{statistics.median(values) / statistics.median(base):.2f}",
            f"{_p99(values):.0f}",
            f"{_p99(values) / _p99(base):.2f}",
        )
    return result


def _p99(values: list[float]) -> float:
    return statistics.quantiles(values, n=100)[98]


async def run(rounds: int, each: int) -> None:
    """Start everything, measure, print."""
    endpoint = await free_endpoint()
    options = BusOptions(connect=endpoint, realm=REALM, connect_timeout=START_TIMEOUT)
    here = str(Path(__file__))
    flags = ("--connect", endpoint, "--realm", REALM)
    async with contextlib.AsyncExitStack() as stack:
        data = stack.enter_context(tempfile.TemporaryDirectory())
        await stack.enter_async_context(process(here, "--route", endpoint))
        caller = await stack.enter_async_context(Module("caller", options=options))
        central = process("-m", "tca_bus", "central", *flags, "--data", data)
        await stack.enter_async_context(central)
        await stack.enter_async_context(process(here, "--answer", endpoint))
        bare = await asyncio.to_thread(zenoh.open, client_config(options))
        stack.callback(bare.close)
        await caller.wait_for(Echo, Carry, "tca.submit", timeout=START_TIMEOUT)
        calls = variants(bare, caller)
        await measure(calls, rounds=1, each=max(10, each // 10))
        Console().print(table(await measure(calls, rounds=rounds, each=each)))


def variants(bare: zenoh.Session, caller: Module) -> dict[str, Call]:
    """What is compared; the first is the measure of the others."""
    text = "x" * 64

    async def ask_bare() -> object:
        return await ask(bare, BARE_KEY, PAYLOAD, attachment=b"", timeout=10.0)

    async def query() -> object:
        return await caller.query(Echo(text=text))

    async def command() -> object:
        handle = await caller.execute(Carry(text=text))
        return await handle.result(timeout=10.0)

    return {"bare Zenoh, bridged": ask_bare, "query": query, "command": command}


def main() -> None:
    """Read the command line and run one of the roles."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=10, help="rounds of all variants")
    parser.add_argument("--calls", type=int, default=200, help="calls of a variant in a round")
    parser.add_argument("--route", metavar="ENDPOINT", help=argparse.SUPPRESS)
    parser.add_argument("--answer", metavar="ENDPOINT", help=argparse.SUPPRESS)
    flags = parser.parse_args()
    if flags.route or flags.answer:
        role = route(flags.route) if flags.route else answer(flags.answer)
    else:
        role = run(flags.rounds, flags.calls)
    with asyncio.Runner(loop_factory=_loop_factory()) as runner:
        runner.run(role)


def _loop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    try:
        import uvloop  # noqa: PLC0415 -- not there on every system
    except ImportError:
        return asyncio.new_event_loop
    return uvloop.new_event_loop


if __name__ == "__main__":
    main()
