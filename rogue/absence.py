"""Going on while the agent is away for a moment: it is being restarted, or the router is."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import TypeVar

from tca_bus import BusGoneError, NoHandlerError, PeerLostError, TimedOutError

T = TypeVar("T")

ABSENT = (BusGoneError, NoHandlerError, PeerLostError, TimedOutError)
"""What passes when a process that went away is back."""

POST_PATIENCE = 30.0
"""Wall seconds for which a message is sent again while the agent is away."""


async def persist(
    call: Callable[[], Awaitable[T]], patience: float = POST_PATIENCE, *, was_there: bool = False
) -> T:
    """Call again while the other side was there and is away; give up after ``patience``.

    ``was_there`` says that it was, though the first call may find it away.
    """
    end = time.monotonic() + patience
    while True:
        try:
            return await call()
        except ABSENT as error:
            was_there = was_there or not isinstance(error, NoHandlerError)
            if not was_there or time.monotonic() >= end:
                raise
        await asyncio.sleep(0.5)
