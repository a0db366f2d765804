"""A module's sign of life: through its event loop, which liveliness tokens do not see."""

from __future__ import annotations

import asyncio
import itertools

from tca_bus._core import Core
from tca_bus._messages import Broadcast, MessageClass
from tca_bus._topics import Topics
from tca_bus._wire import encode_message

PERIOD = 1.0
"""Wall seconds between two heartbeats."""


class Heartbeat(Broadcast):
    """A module's event loop still turns; ``lag`` is by how many seconds it came late."""

    wire_name = "tca.heartbeat"

    module: str
    incarnation: str
    number: int
    lag: float


async def beat(core: Core, topics: Topics) -> None:
    """Broadcast a heartbeat each second, with how late it came."""
    loop = asyncio.get_running_loop()
    due = loop.time()
    for number in itertools.count():
        late = max(0.0, loop.time() - due)
        message = Heartbeat(module=core.name, incarnation=core.incarnation, number=number, lag=late)
        topics.publish(MessageClass.BROADCAST, message.wire_name, encode_message(message))
        due = max(due + PERIOD, loop.time())
        await asyncio.sleep(due - loop.time())
