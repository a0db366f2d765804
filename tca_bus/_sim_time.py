"""Joins a module's simulated clock to the bus."""

from __future__ import annotations

import asyncio
from typing import Any

from tca_bus._clock import Awaited, SimulatedClock
from tca_bus._core import Core
from tca_bus._messages import Broadcast, MessageClass
from tca_bus._time_messages import AwaitTime, Settle, Settled, SimulatedTime
from tca_bus._topics import Arrival, Topics
from tca_bus._wire import encode_message

REPEAT_PERIOD = 1.0
"""Wall seconds between repetitions of what a module waits for."""


SETTLING_TURNS = 20
"""Turns of the loop in which what has just arrived sets to work whom it concerns."""


class SimTimeLink:
    """Moves the clock with `SimulatedTime` and tells with `AwaitTime` who waits for it."""

    def __init__(self, core: Core, topics: Topics) -> None:
        self._core = core
        self._topics = topics
        self._maker = ""
        self._asked = asyncio.Event()
        self._number = 0
        self.clock = SimulatedClock(self._tell)

    def begin(self) -> None:
        """Listen to the time, repeat what is waited for, and say when all is taken."""
        self._core.spawn(self._repeat(), name=f"{self._core.name}.await_time")
        self._core.spawn(self._settle(), name=f"{self._core.name}.settle")
        self._topics.listen_to(SimulatedTime, self._take)
        self._topics.listen_to(Settle, self._take_settle)

    def _take(self, arrival: Arrival[Any]) -> None:
        if arrival.envelope.sender != self._maker:
            self._maker = arrival.envelope.sender
            self._say_settled(0)
        self.clock.move_to(arrival.value.time)

    def _take_settle(self, arrival: Arrival[Any]) -> None:
        self._number = arrival.value.number
        self._asked.set()

    async def _settle(self) -> None:
        while True:
            await self._asked.wait()
            self._asked.clear()
            for _ in range(SETTLING_TURNS):
                await asyncio.sleep(0)
            self._say_settled(self._number)

    def _say_settled(self, number: int) -> None:
        core = self._core
        self._publish(Settled(module=core.name, incarnation=core.incarnation, number=number))

    def _tell(self, awaited: Awaited | None) -> None:
        message = AwaitTime(
            module=self._core.name,
            incarnation=self._core.incarnation,
            until=awaited.until if awaited else None,
            moves=awaited is not None and awaited.moves,
        )
        self._publish(message)

    def _publish(self, message: Broadcast) -> None:
        payload = encode_message(message)
        self._topics.publish(MessageClass.BROADCAST, message.wire_name, payload)

    async def _repeat(self) -> None:
        while True:
            await asyncio.sleep(REPEAT_PERIOD)
            awaited = self.clock.awaited()
            if awaited is not None:
                self._tell(awaited)
