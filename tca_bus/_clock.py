"""Wall time or simulated time behind one interface.

What waits for the world (a period, a deadline, an answer of a person) waits on a `Clock`; what
waits for the transport waits on wall time.
"""

from __future__ import annotations

import asyncio
import heapq
import itertools
import time
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import (
    AbstractAsyncContextManager,
    AbstractContextManager,
    asynccontextmanager,
    contextmanager,
    nullcontext,
)
from dataclasses import dataclass, field
from typing import ClassVar

from tca_bus._errors import TimedOutError
from tca_bus._time_messages import TIME_GRAIN

LONGEST_NAP = 1.0
"""Wall seconds after which a wait for the time of day looks at it again."""


class Clock(ABC):
    """The time of the world, in seconds since the epoch."""

    is_simulated: ClassVar[bool]
    """Whether a robot tells this time; else it is this machine's."""

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
        """Wait passively until ``when``, without making time move.

        In lockstep time stops there until this module was told; see `at` for one that wants to
        act before it goes on.
        """

    @abstractmethod
    def at(self, when: float) -> AbstractAsyncContextManager[None]:
        """Wait passively until ``when``, and then do the block: in lockstep, at that very time.

        Simulated time stands still until the block is left, for some wall seconds at most; the
        module that makes it goes on then, and says so in its log. So nothing in the block may
        wait for time to pass.
        """

    @abstractmethod
    def hold(self) -> AbstractContextManager[None]:
        """Do the block while, in lockstep, time stands still: `at` the time that it is now.

        Raises:
            TimedOutError: Simulated time is not known yet.
        """

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

    is_simulated = False

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

    def at(self, when: float) -> AbstractAsyncContextManager[None]:
        """Wait until ``when``, and do the block."""
        return _after(self.sleep_until(when))

    def hold(self) -> AbstractContextManager[None]:
        """Do the block; the wall's time stands still for nobody."""
        return nullcontext()

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


@asynccontextmanager
async def _after(wait: Awaitable[None]) -> AsyncIterator[None]:
    await wait
    yield


@dataclass(frozen=True, slots=True)
class Awaited:
    """The earliest time that somebody waits for, and whether somebody waits actively.

    A time that has come already is that of a block which time stands still for.
    """

    until: float
    moves: bool


@dataclass(order=True)
class _Alarm:
    when: float
    number: int
    ring: Callable[[], None] = field(compare=False)
    is_active: bool = field(compare=False)
    holds: bool = field(compare=False, default=False)
    is_over: bool = field(compare=False, default=False)


class SimulatedClock(Clock):
    """A clock that moves when `move_to` is called.

    ``announce`` is called on the loop, soon after it changed, with what is waited for, None when
    nobody waits.
    """

    is_simulated = True

    def __init__(self, announce: Callable[[Awaited | None], None] | None = None) -> None:
        self._announce = announce
        self._time: float | None = None
        self._ready = asyncio.Event()
        self._alarms: list[_Alarm] = []
        self._holds: list[_Alarm] = []
        self._numbers = itertools.count()
        self._announced: Awaited | None = None
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

    def at(self, when: float) -> AbstractAsyncContextManager[None]:
        """Wait until ``when``, whoever makes the time move, and do the block at that time."""
        return self._at(when)

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Do the block while simulated time stands still, in lockstep."""
        hold = _Alarm(self.now(), next(self._numbers), _nothing, is_active=False, holds=True)
        self._ring(hold)
        # Before anything that is sent from within the block.
        self._announce_now()
        try:
            yield
        finally:
            self._end_alarm(hold)

    def timeout(self, seconds: float) -> AbstractAsyncContextManager[None]:
        """Raise TimeoutError from the block after ``seconds`` of simulated time."""
        return self._timeout(seconds)

    def move_to(self, now: float) -> None:
        """Set the time and wake all whose time has come; it may go back after a restart."""
        # Told once more, a time does not go back behind one for which somebody was woken.
        if self._time is None or not now <= self._time <= now + TIME_GRAIN:
            self._time = now
        self._ready.set()
        while self._alarms and self._alarms[0].when <= now + TIME_GRAIN:
            self._ring(heapq.heappop(self._alarms))
        self._announce_soon()

    def awaited(self) -> Awaited | None:
        """What is waited for."""
        waits = [alarm for alarm in self._alarms if not alarm.is_over] + self._holds
        if not waits:
            return None
        earliest = min(alarm.when for alarm in waits)
        return Awaited(earliest, moves=any(alarm.is_active for alarm in waits))

    def _ring(self, alarm: _Alarm) -> None:
        if alarm.is_over:
            return
        # Who has waited until then must not read a time before it.
        self._time = max(self.now(), alarm.when)
        alarm.is_over = True
        if alarm.holds:
            self._holds.append(alarm)
        alarm.ring()

    async def _wait(self, when: float, *, is_active: bool) -> None:
        async with self._wait_and_do(when, is_active=is_active):
            pass

    @asynccontextmanager
    async def _at(self, when: float) -> AsyncIterator[None]:
        async with self._wait_and_do(when, is_active=False, holds=True):
            yield

    @asynccontextmanager
    async def _wait_and_do(
        self, when: float, *, is_active: bool, holds: bool = False
    ) -> AsyncIterator[None]:
        future = asyncio.get_running_loop().create_future()
        alarm = _Alarm(when, next(self._numbers), lambda: _settle(future), is_active, holds)
        try:
            if self._time is not None and when <= self._time + TIME_GRAIN:
                self._ring(alarm)
                await asyncio.sleep(0)
            else:
                heapq.heappush(self._alarms, alarm)
            self._announce_soon()
            await future
            yield
        finally:
            self._end_alarm(alarm)

    @asynccontextmanager
    async def _timeout(self, seconds: float) -> AsyncIterator[None]:
        async with asyncio.timeout(None) as limit:
            now = asyncio.get_running_loop().time
            when = self.now() + seconds
            number = next(self._numbers)
            alarm = _Alarm(when, number, lambda: limit.reschedule(now()), is_active=True)
            heapq.heappush(self._alarms, alarm)
            self._announce_soon()
            try:
                yield
            finally:
                self._end_alarm(alarm)

    def _end_alarm(self, alarm: _Alarm) -> None:
        alarm.is_over = True
        if alarm in self._holds:
            self._holds.remove(alarm)
        while self._alarms and self._alarms[0].is_over:
            heapq.heappop(self._alarms)
        self._announce_soon()

    def _announce_soon(self) -> None:
        # After those who were woken have run: most of them wait again at once.
        if self._announce is not None and not self._is_announcing:
            self._is_announcing = True
            asyncio.get_running_loop().call_soon(self._announce_at_last)

    def _announce_at_last(self) -> None:
        self._is_announcing = False
        self._announce_now()

    def _announce_now(self) -> None:
        awaited = self.awaited()
        if self._announce is not None and awaited != self._announced:
            self._announced = awaited
            self._announce(awaited)


def _nothing() -> None:
    """Nobody is to be woken."""


def _settle(future: asyncio.Future[None]) -> None:
    if not future.done():
        future.set_result(None)
