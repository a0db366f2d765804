"""tca_bus itself: validated messages, typed errors, presence, requests handled once."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import AsyncIterator
from functools import partial
from typing import Literal

from pydantic import BaseModel

from contenders.base import START_TIMEOUT, Contender, Counter, Place, Received
from tca_bus import BusOptions, Command, Context, Goal, Inform, Module, Query, TaskContext

REALM = "bench"
CHILDREN = 10

Links = Literal["router", "direct"]


class Echo(Query[str]):
    """Give the text back."""

    text: str


class Note(Inform):
    """Count the text."""

    text: str


class Stock(BaseModel):
    """What was counted."""

    count: int
    seconds: float
    delays: list[float]


class TakeStock(Query[Stock]):
    """Say what was counted, and whether to begin anew."""

    forget: bool = False


class Carry(Command[str]):
    """Give the text back, as a task."""

    text: str


class Deliver(Goal[int]):
    """Carry the text as often as there are children."""

    text: str


def options(place: Place, links: Links) -> BusOptions:
    """How the modules of a run join the bus; each kind of links has a realm of its own."""
    return BusOptions(
        connect=place.router, realm=f"{REALM}-{links}", links=links, connect_timeout=START_TIMEOUT
    )


async def serve(place: Place, *, links: Links) -> None:
    """Run the callee."""
    module = Module("callee", options=options(place, links))
    counter = Counter()

    @module.handler(Echo)
    async def echo(message: Echo, _: Context) -> str:
        return message.text

    @module.handler(TakeStock)
    async def take_stock(message: TakeStock, _: Context) -> Stock:
        if message.forget:
            counter.forget()
        return Stock.model_validate(counter.stock())

    @module.handler(Note)
    async def note(message: Note, _: Context) -> None:
        counter.take(message.text)

    @module.handler(Carry, capacity=100)
    async def carry(message: Carry, _: TaskContext) -> str:
        return message.text

    @module.handler(Deliver, capacity=100)
    async def deliver(message: Deliver, context: TaskContext) -> int:
        for _ in range(CHILDREN):
            await context.execute(Carry(text=message.text))
        return CHILDREN

    async with module:
        await module.serve_forever()


class BusClient:
    """A module that asks, tells, and sends tasks."""

    def __init__(self, module: Module) -> None:
        self._module = module

    async def ask(self, text: str) -> str:
        return await self._module.query(Echo(text=text))

    async def tell(self, text: str) -> None:
        await self._module.inform(Note(text=text))

    async def tell_many(self, texts: list[str]) -> None:
        """Send many texts one way, together."""
        await self._module.inform_many([Note(text=text) for text in texts])

    async def received(self) -> Received:
        return Received(**(await self._module.query(TakeStock())).model_dump())

    async def forget(self) -> None:
        await self._module.query(TakeStock(forget=True))

    async def command(self, text: str) -> str:
        """Send a command, have it acknowledged, and wait for its result."""
        handle = await self._module.execute(Carry(text=text))
        return await handle.result(timeout=START_TIMEOUT)

    async def goal(self, text: str) -> int:
        """Send a goal with ten children and wait until all is done."""
        handle = await self._module.expand(Deliver(text=text))
        return await handle.result(timeout=START_TIMEOUT)


@contextlib.asynccontextmanager
async def connect(place: Place, *, links: Links) -> AsyncIterator[BusClient]:
    """Join the bus as the caller; ready when callee and central are there."""
    async with Module("caller", options=options(place, links)) as module:
        await module.wait_for(Echo, Deliver, "tca.submit", timeout=START_TIMEOUT)
        yield BusClient(module)


def central(place: Place, *, links: Links) -> list[str]:
    """The command line of central, with its journal in a file."""
    where = ["--connect", place.router, "--realm", f"{REALM}-{links}", "--links", links]
    flags = [*where, "--log-level", "warning", "--data", str(place.data / links)]
    return [sys.executable, "-m", "tca_bus", "central", *flags]


def _contender(name: str, title: str, links: Links) -> Contender:
    return Contender(
        name,
        title,
        partial(serve, links=links),
        partial(connect, links=links),
        helper=partial(central, links=links),
    )


CONTENDERS = [
    _contender("ours", "tca_bus, router", "router"),
    _contender("ours-direct", "tca_bus, direct", "direct"),
]
