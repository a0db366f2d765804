"""Joins a module's simulated clock to the bus."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from tca_bus._clock import Awaited, SimulatedClock
from tca_bus._core import Core
from tca_bus._messages import MessageClass
from tca_bus._time_messages import AwaitTime, SimulatedTime
from tca_bus._topics import Arrival, Topics
from tca_bus._wire import encode_message

REPEAT_PERIOD = 1.0
"""Wall seconds between repetitions of what a module waits for."""


class SimTimeLink:
    """Moves the clock with `SimulatedTime` and tells with `AwaitTime` who waits for it."""

    def __init__(self, core: Core, topics: Topics) -> None:
        self._core = core
        self._topics = topics
        self.clock = SimulatedClock(self._tell)

    def begin(self) -> Callable[[], None]:
        """Listen to the time and repeat what is waited for."""
        self._core.spawn(self._repeat(), name=f"{self._core.name}.await_time")
        return self._topics.listen_to(SimulatedTime, self._take)

    def _take(self, arrival: Arrival[Any]) -> None:
        self.clock.move_to(arrival.value.time)

    def _tell(self, awaited: Awaited | None) -> None:
        message = AwaitTime(
            module=self._core.name,
            incarnation=self._core.incarnation,
            until=awaited.until if awaited else None,
            moves=awaited is not None and awaited.moves,
        )
        payload = encode_message(message)
        self._topics.publish(MessageClass.BROADCAST, message.wire_name, payload)

    async def _repeat(self) -> None:
        while True:
            await asyncio.sleep(REPEAT_PERIOD)
            awaited = self.clock.awaited()
            if awaited is not None:
                self._tell(awaited)
