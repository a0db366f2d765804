"""Helpers for tests of modules: a router, central, modules that answer as told, clocks by hand.

``docs/testing.md`` shows whole test files. ::

    async with bus() as options, central(options), Module("asker", options=options) as module:
        await eventually(lambda: module.is_connected)
"""

from __future__ import annotations

import asyncio
import inspect
import secrets
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Literal

from tca_bus._central import Central
from tca_bus._central_absences import LOST_AFTER
from tca_bus._clock import SimulatedClock
from tca_bus._module import Module
from tca_bus._options import BusOptions
from tca_bus._router import Router
from tca_bus._scripted import Call, Hold, ScriptedModule
from tca_bus._time_messages import SimulatedTime

__all__ = [
    "FREE_PORT",
    "Call",
    "Hold",
    "ManualClock",
    "ScriptedModule",
    "TimeSource",
    "bus",
    "central",
    "eventually",
]

FREE_PORT = "tcp/127.0.0.1:0"

POLL_PERIOD = 0.01
"""Wall seconds between two looks at a condition."""

PATIENCE = 30.0
"""Wall seconds to wait for a condition. So long costs only a test that fails anyway, and a machine
that tests many things at once is slow, not wrong."""

LOOP_TURNS = 10
"""Turns of the event loop in which tasks that wait for nothing else come to their next wait."""


@asynccontextmanager
async def bus(
    *, realm: str | None = None, clock: Literal["wall", "sim"] = "wall"
) -> AsyncIterator[BusOptions]:
    """Run a router on a free port; gives the options with which modules join it.

    Each bus has a realm of its own unless ``realm`` names one.
    """
    async with Router(FREE_PORT) as router:
        name = realm or f"test-{secrets.token_hex(4)}"
        yield BusOptions(connect=router.endpoint, realm=name, clock=clock)


@asynccontextmanager
async def central(
    options: BusOptions, *, data: Path | None = None, lost_after: float = LOST_AFTER
) -> AsyncIterator[None]:
    """Run central in this process; ``data`` is the folder of its journal, None for memory.

    A module that is out of reach for ``lost_after`` wall seconds is lost.

    Raises:
        RefusedError: There is a central on the realm already.
        ConfigError: The journal cannot be used.
        JournalError: The journal could not be written any more; the block was cancelled.
    """
    async with Central(options, data=data, lost_after=lost_after):
        yield


async def eventually(
    condition: Callable[[], object | Awaitable[object]],
    *,
    timeout: float = PATIENCE,
    what: str = "the condition",
) -> None:
    """Wait until ``condition``, which may be async, is true.

    Raises:
        AssertionError: It is still not true after ``timeout`` wall seconds.
    """
    try:
        async with asyncio.timeout(timeout):
            while not await _value_of(condition):  # noqa: ASYNC110
                await asyncio.sleep(POLL_PERIOD)
    except TimeoutError as error:
        raise AssertionError(f"{what} did not come true within {timeout:g} s") from error


async def _value_of(condition: Callable[[], object | Awaitable[object]]) -> object:
    value = condition()
    return await value if inspect.isawaitable(value) else value


async def _turn_the_loop() -> None:
    for _ in range(LOOP_TURNS):
        await asyncio.sleep(0)


class ManualClock(SimulatedClock):
    """A clock that stands still until a test moves it; begins at ``start``."""

    def __init__(self, start: float = 0.0) -> None:
        super().__init__()
        self._time = start
        self._ready.set()

    async def advance(self, seconds: float) -> None:
        """Let what has begun run, move the time, and let those who were woken run."""
        await _turn_the_loop()
        self.move_to(self.now() + seconds)
        await _turn_the_loop()


class TimeSource:
    """Broadcasts simulated time from a module, as the robot does; the test moves it.

    ``speed`` is what it claims: simulated seconds per wall second, None for lockstep.
    """

    def __init__(self, module: Module, *, start: float = 0.0, speed: float | None = None) -> None:
        self._module = module
        self._speed = speed
        self.now = start

    async def tell(self) -> None:
        """Broadcast the time as it is, for those who have joined since."""
        await self._module.broadcast(SimulatedTime(time=self.now, speed=self._speed))

    async def advance(self, seconds: float) -> None:
        """Move the simulated time and broadcast it."""
        self.now += seconds
        await self.tell()
