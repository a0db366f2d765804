"""What the benchmark asks of every contender."""

from __future__ import annotations

import importlib.util
import json
import statistics
import time
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

STOCK = "?"
"""Asked of a bare callee, it is answered with what its `Counter` holds, as JSON."""

FORGET = "!"
"""Asked of a bare callee, its `Counter` begins anew."""

MOST_DELAYS = 1000

START_TIMEOUT = 30.0
"""Wall seconds in which the processes of a contender are ready."""


@dataclass(frozen=True)
class Place:
    """Where a contender's processes meet: the Zenoh router, a free TCP port, a folder."""

    router: str
    port: int
    data: Path


@dataclass(frozen=True)
class Received:
    """What the callee has seen of one-way messages: number, seconds, and delays in µs.

    The delays of a flood are left out: they say how long its queue was.
    """

    count: int
    seconds: float
    delays: list[float]


class Client(Protocol):
    """The calling side of a contender, connected."""

    async def ask(self, text: str) -> object:
        """Send the text and wait for it to come back."""
        ...

    async def tell(self, text: str) -> None:
        """Send the text one way."""
        ...

    async def received(self) -> Received:
        """What the callee has counted of one-way messages."""
        ...

    async def forget(self) -> None:
        """Have the callee begin to count anew."""
        ...


class BareClient(ABC):
    """The part of a client whose callee answers with `Counter.answer`."""

    @abstractmethod
    async def ask(self, text: str) -> bytes:
        """Send the text and wait for it to come back."""

    async def received(self) -> Received:
        """What the callee has counted of one-way messages."""
        return Received(**json.loads(await self.ask(STOCK)))

    async def forget(self) -> None:
        """Have the callee begin to count anew."""
        await self.ask(FORGET)


@dataclass(frozen=True, eq=False)
class Contender:
    """One way to talk between two processes.

    ``helper`` is the command line of a process that it needs beside its own callee; ``serve``
    runs the callee for ever, ``connect`` gives the caller.
    """

    name: str
    title: str
    serve: Callable[[Place], Awaitable[None]]
    connect: Callable[[Place], AbstractAsyncContextManager[Client]]
    needs: tuple[str, ...] = ()
    helper: Callable[[Place], list[str]] | None = None
    why_not: Callable[[], str | None] = field(default=lambda: None)

    def missing(self) -> str | None:
        """What is missing on this machine, if something is."""
        for package in self.needs:
            if importlib.util.find_spec(package) is None:
                return f"no package {package!r} here: uv sync --group bench"
        return self.why_not()


class Counter:
    """Counts one-way messages as they arrive; their text begins with when they were sent."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self._count = 0
        self._first = self._last = 0
        self._delays: list[int] = []

    def take(self, text: str | bytes) -> None:
        """Note an arrival; the clock is the same in all processes of a machine."""
        now = time.perf_counter_ns()
        if not self._count:
            self._first = now
        self._count += 1
        self._last = now
        if self._count <= MOST_DELAYS:
            self._delays.append(now - int(text[:20]))

    def stock(self) -> dict[str, Any]:
        """What arrived so far."""
        delays = [delay / 1e3 for delay in self._delays] if self._count <= MOST_DELAYS else []
        return {
            "count": self._count,
            "seconds": (self._last - self._first) / 1e9,
            "delays": delays,
        }

    def answer(self, data: bytes) -> bytes:
        """The answer to what a bare callee was asked: its stock, or the same again."""
        if data == STOCK.encode():
            return json.dumps(self.stock()).encode()
        if data == FORGET.encode():
            self.forget()
        return data


def stamped(size: int) -> str:
    """A text of ``size`` letters that begins with the time."""
    return f"{time.perf_counter_ns():020d}".ljust(size, "x")


def p99(values: list[float]) -> float:
    """The 99th percentile."""
    if len(values) < 2:
        return values[0] if values else 0.0
    return statistics.quantiles(values, n=100, method="inclusive")[98]
