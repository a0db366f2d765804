"""Deadlines against what is accepted: refused at once, put off, or warned of later."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Awaitable, Callable, Iterable

from rogue.errands import Travel
from rogue.errors import TooLateError
from rogue.memory import Store
from rogue.messages import DeliveryRequest, Filled
from rogue.requests._book import RequestBook
from rogue.requests._lateness import warnings
from rogue.requests._outlook import Outlook
from rogue.requests._pace import at_pace
from tca_bus import Module

log = logging.getLogger(__name__)

LEARN_WITHIN = 3.0
"""Wall seconds in which distances are asked for; without them straight lines count."""

SLACK = 1.5
"""A default deadline that cannot be met is put off to so many times the time that is needed."""

REST = 0.05
"""Seconds of the module's clock for each open request between two looks at all of them: a long
tour is not to be looked at again and again."""

STEPS = 40
"""Steps from which it is learned how fast the robot gets on."""

Learn = Callable[[Iterable[str]], Awaitable[None]]
"""Finds out how far it is between rooms."""


class Prospects:
    """Says when requests can be done, and what is to be feared for those that were accepted."""

    def __init__(
        self, *, module: Module, store: Store, book: RequestBook, travel: Travel, learn: Learn
    ) -> None:
        self._module = module
        self._store = store
        self._book = book
        self._travel = travel
        self._outlook = Outlook()
        self._learn = learn

    async def get_ready(self, request: DeliveryRequest) -> None:
        """Learn the distances that a new request brings in."""
        facts = await self._store.facts()
        rooms = {request.pickup, request.deliver, *({facts.room} if facts.room else ())}
        rooms |= {room for r in self._book.open_requests() for room in (r.pickup, r.deliver)}
        try:
            async with asyncio.timeout(LEARN_WITHIN):
                await self._learn(rooms)
        except TimeoutError:
            log.warning("the navigator does not say how far it is; straight lines count")

    async def in_time(
        self, request: DeliveryRequest, filled: tuple[Filled, ...]
    ) -> tuple[DeliveryRequest, tuple[Filled, ...]]:
        """A new request, if it can be done in time; its deadline is put off if it is a default.

        Raises:
            TooLateError: it cannot.
        """
        facts, now = await self._store.facts(), self._module.clock.now()
        others = self._book.open_requests()
        travel = await self._pace()
        promise = self._outlook.promise(request, others, travel=travel, facts=facts, now=now)
        if promise.can_be_kept or not math.isfinite(promise.earliest):
            # What cannot be told is no reason to refuse.
            return request, filled
        if not any(one.slot == "deadline" and one.source == "default" for one in filled):
            raise TooLateError(request.deadline, earliest=promise.earliest, alone=promise.alone)
        minutes = max(1, round(SLACK * (promise.earliest - now) / 60.0))
        put_off = Filled(slot="deadline", value=f"{minutes}min", source="default")
        kept = tuple(one for one in filled if one.slot != "deadline")
        later = request.model_copy(update={"deadline": now + 60.0 * minutes})
        return later, (*kept, put_off)

    async def watch(self) -> None:
        """Tell of requests that will be late, whenever something has changed, until cancelled."""
        clock = self._module.clock
        while True:
            await self._book.prospects_changed.wait()
            with clock.hold():
                await self.review()
                rested = clock.now() + REST * len(self._book.open_requests())
            await clock.watch_until(rested)

    async def review(self) -> None:
        """Look at all open requests once, and tell of those that will be late."""
        self._book.prospects_changed.clear()
        facts, now = await self._store.facts(), self._module.clock.now()
        travel = await self._pace()
        requests = self._book.open_requests()
        expected = self._outlook.expected(requests, travel=travel, facts=facts, now=now)
        for request, warning in warnings(requests, expected, now):
            await self._book.warn(request.id, warning)

    async def _pace(self) -> Travel:
        return at_pace(self._travel, await self._store.timed_steps(STEPS))
