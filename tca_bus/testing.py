"""Helpers for tests of modules: a router on a free port, a clock by hand, waiting for conditions."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager

from tca_bus._clock import Clock
from tca_bus._module import Module
from tca_bus._options import BusOptions


@asynccontextmanager
async def bus(*, realm: str = "test") -> AsyncIterator[BusOptions]:
    """Run a router on a free port; gives the options with which modules join it."""
    raise NotImplementedError
    yield BusOptions()


async def eventually(
    condition: Callable[[], object | Awaitable[object]],
    *,
    timeout: float = 10.0,  # noqa: ASYNC109
    what: str = "the condition",
) -> None:
    """Wait until ``condition`` is true; AssertionError after ``timeout`` wall seconds."""
    raise NotImplementedError


class ManualClock(Clock):
    """A clock that stands still until a test calls `advance`; begins at ``start``."""

    def __init__(self, start: float = 0.0) -> None:
        raise NotImplementedError

    def advance(self, seconds: float) -> None:
        """Move the time and wake who waited for it."""
        raise NotImplementedError


class TimeSource:
    """Broadcasts simulated time from a module, as the robot does; moved by the test."""

    def __init__(self, module: Module, *, start: float = 0.0, speed: float | None = None) -> None:
        raise NotImplementedError

    async def advance(self, seconds: float) -> None:
        """Move the simulated time and broadcast it."""
        raise NotImplementedError
