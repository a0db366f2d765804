"""Wall time or simulated time behind one interface.

What waits for the world (a period, a deadline, an answer of a person) waits on a `Clock`; what
waits for the transport waits on wall time.
"""

from __future__ import annotations

import asyncio
import heapq
import itertools
import math
import time
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field

from tca_bus._errors import TimedOutError

LONGEST_NAP = 1.0
"""Wall seconds after which a wait for the time of day looks at it again."""


class Clock(ABC):
    """The time of the world, in seconds since the epoch."""

    @abstractmethod
    def now(self) -> float:
        """The time.

        Raises:
            TimedOutError: Simulated time is not known yet; see `wait_ready`.
        """

    @abstractmethod
    async def sleep_until(self, when: float) -> None:
        """Wait actively until ``when``: in lockstep this makes simulated time move."""

    @abstractmethod
    async def watch_until(self, when: float) -> None:
        """Wait passively until ``when``: told when the time has come, without making it move."""

    @abstractmethod
    def timeout(self, seconds: float) -> AbstractAsyncContextManager[None]:
        """Raise TimeoutError from the block after ``seconds``; an active wait."""

    @abstractmethod
    async def wait_ready(self, timeout: float) -> None:
        """Wait until the time is known.

        Raises:
            TimedOutError: It is not known within ``timeout`` wall seconds.
        """

    async def sleep(self, seconds: float) -> None:
        """Wait actively for ``seconds``."""
        await self.sleep_until(self.now() + seconds)


class WallClock(Clock):
    """The time of this machine."""

    def now(self) -> float:
        """The time of day."""
        return time.time()

    async def sleep_until(self, when: float) -> None:
        """Wait until ``when``; a clock that is set meanwhile is noticed within a second."""
        await asyncio.sleep(0)
        while (left := when - time.time()) > 0:  # noqa: ASYNC110
            await asyncio.sleep(min(left, LONGEST_NAP))

    async def watch_until(self, when: float) -> None:
        """Wait until ``when``; on the wall there is no difference."""
        await self.sleep_until(when)

    def timeout(self, seconds: float) -> AbstractAsyncContextManager[None]:
        """Raise TimeoutError from the block after ``seconds``."""
        return _wall_timeout(seconds)

    async def wait_ready(self, timeout: float) -> None:
        """Wall time is always known."""
        del timeout


@asynccontextmanager
async def _wall_timeout(seconds: float) -> AsyncIterator[None]:
    async with asyncio.timeout(seconds):
        yield


@dataclass(order=True)
class _Alarm:
    when: float
    number: int
    ring: Callable[[], None] = field(compare=False)
    is_active: bool = field(compare=False)
    is_over: bool = field(compare=False, default=False)


class SimulatedClock(Clock):
    """A clock that moves when `move_to` is called.

    ``announce`` is called on the loop, soon after it changed, with the earliest time that
    somebody waits for actively, None when nobody does.
    """

    def __init__(self, announce: Callable[[float | None], None] | None = None) -> None:
        self._announce = announce
        self._time: float | None = None
        self._ready = asyncio.Event()
        self._alarms: list[_Alarm] = []
        self._numbers = itertools.count()
        self._announced: float | None = None
        self._is_announcing = False

    def now(self) -> float:
        """The latest simulated time."""
        if self._time is None:
            raise TimedOutError("simulated time, which no module has told yet", 0.0)
        return self._time

    async def wait_ready(self, timeout: float) -> None:
        """Wait for the first simulated time."""
        try:
            async with asyncio.timeout(timeout):
                await self._ready.wait()
        except TimeoutError as error:
            raise TimedOutError("simulated time", timeout) from error

    async def sleep_until(self, when: float) -> None:
        """Wait until ``when``; in lockstep simulated time moves for it."""
        await self._wait(when, is_active=True)

    async def watch_until(self, when: float) -> None:
        """Wait until ``when``, whoever makes the time move."""
        await self._wait(when, is_active=False)

    def timeout(self, seconds: float) -> AbstractAsyncContextManager[None]:
        """Raise TimeoutError from the block after ``seconds`` of simulated time."""
        return self._timeout(seconds)

    def move_to(self, now: float) -> None:
        """Set the time and wake all whose time has come; it may go back after a restart."""
        self._time = now
        self._ready.set()
        while self._alarms and self._alarms[0].when <= now:
            alarm = heapq.heappop(self._alarms)
            if not alarm.is_over:
                alarm.is_over = True
                alarm.ring()
        self._announce_soon()

    def awaited(self) -> float | None:
        """The earliest time that somebody waits for actively."""
        waits = (a.when for a in self._alarms if a.is_active and not a.is_over)
        earliest = min(waits, default=math.inf)
        return None if earliest == math.inf else earliest

    async def _wait(self, when: float, *, is_active: bool) -> None:
        if self._time is not None and when <= self._time:
            await asyncio.sleep(0)
            return
        future = asyncio.get_running_loop().create_future()
        alarm = self._set_alarm(when, lambda: _settle(future), is_active=is_active)
        try:
            await future
        finally:
            self._end_alarm(alarm)

    @asynccontextmanager
    async def _timeout(self, seconds: float) -> AsyncIterator[None]:
        async with asyncio.timeout(None) as limit:
            now = asyncio.get_running_loop().time
            when = self.now() + seconds
            alarm = self._set_alarm(when, lambda: limit.reschedule(now()), is_active=True)
            try:
                yield
            finally:
                self._end_alarm(alarm)

    def _set_alarm(self, when: float, ring: Callable[[], None], *, is_active: bool) -> _Alarm:
        alarm = _Alarm(when, next(self._numbers), ring, is_active)
        heapq.heappush(self._alarms, alarm)
        self._announce_soon()
        return alarm

    def _end_alarm(self, alarm: _Alarm) -> None:
        alarm.is_over = True
        while self._alarms and self._alarms[0].is_over:
            heapq.heappop(self._alarms)
        self._announce_soon()

    def _announce_soon(self) -> None:
        # After those who were woken have run: most of them wait again at once.
        if self._announce is not None and not self._is_announcing:
            self._is_announcing = True
            asyncio.get_running_loop().call_soon(self._announce_now)

    def _announce_now(self) -> None:
        self._is_announcing = False
        awaited = self.awaited()
        if self._announce is not None and awaited != self._announced:
            self._announced = awaited
            self._announce(awaited)


def _settle(future: asyncio.Future[None]) -> None:
    if not future.done():
        future.set_result(None)
