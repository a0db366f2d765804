"""Central's alarms: what waits for a time of its clock."""

from __future__ import annotations

import asyncio
import heapq
import itertools
from typing import TYPE_CHECKING

from tca_bus.tasktree import Alarmed, SetAlarm

if TYPE_CHECKING:
    from tca_bus._central import Central

Entry = tuple[float, int, SetAlarm]


class Alarms:
    """Wakes the tree at its times: one task for delays, one for deadlines.

    A delay is waited for actively, so that in lockstep simulated time moves for it.
    """

    def __init__(self, central: Central) -> None:
        self._central = central
        self._numbers = itertools.count()
        self._heaps: dict[bool, list[Entry]] = {True: [], False: []}
        self._news = {True: asyncio.Event(), False: asyncio.Event()}

    def begin(self) -> None:
        """Start to wait."""
        for passive, name in ((True, "deadlines"), (False, "delays")):
            self._central.module.start(self._run(passive=passive), name=f"central.{name}")

    def add(self, alarm: SetAlarm) -> None:
        """Wake the tree at the time of the alarm."""
        heap = self._heaps[alarm.passive]
        heapq.heappush(heap, (alarm.when, next(self._numbers), alarm))
        if heap[0][2] is alarm:
            self._news[alarm.passive].set()

    async def _run(self, *, passive: bool) -> None:
        heap, news = self._heaps[passive], self._news[passive]
        while True:
            news.clear()
            if not heap:
                await news.wait()
            elif await self._came(heap[0][0], news, passive=passive):
                self._ring(heapq.heappop(heap)[2])

    async def _came(self, when: float, news: asyncio.Event, *, passive: bool) -> bool:
        """Wait for a time, or for an alarm that comes before it."""
        clock = self._central.module.clock
        wait = clock.watch_until(when) if passive else clock.sleep_until(when)
        waiting = asyncio.ensure_future(wait)
        sooner = asyncio.ensure_future(news.wait())
        try:
            await asyncio.wait({waiting, sooner}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            sooner.cancel()
            waiting.cancel()
        return waiting.done() and not waiting.cancelled()

    def _ring(self, alarm: SetAlarm) -> None:
        if self._central.tree.is_awaited(alarm.id, alarm.key):
            self._central.happen(Alarmed(self._central.now(), alarm.id, alarm.key))
