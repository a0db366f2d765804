"""Waiting for the end of a request, however often agent and router go away meanwhile."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

from rogue.absence import ABSENT
from rogue.cli._client import ask
from rogue.messages import DeliveryRequest, RequestChanged, RequestState, ShowRequest
from tca_bus import Module, Subscription

POLL_SECONDS = 2.0
"""Wall seconds after which a state is asked for that nobody has told of."""

EXIT_CODES = {RequestState.COMPLETED: 0, RequestState.FAILED: 1, RequestState.CANCELED: 6}
"""What a command that waited ends with."""


async def states(module: Module, request_id: str) -> AsyncIterator[DeliveryRequest]:
    """The request each time that it stands otherwise, until it has ended."""
    last: DeliveryRequest | None = None
    async with module.subscribe(RequestChanged) as changes:
        while last is None or not last.state.is_final:
            request = await _look(module, request_id)
            if request is not None and request != last:
                last = request
                yield request
            else:
                await _change(changes, request_id)


async def _look(module: Module, request_id: str) -> DeliveryRequest | None:
    try:
        return (await ask(module, ShowRequest(id=request_id))).request
    except ABSENT:
        await asyncio.sleep(POLL_SECONDS / 4)
        return None


async def _change(changes: Subscription[RequestChanged], request_id: str) -> None:
    """Wait until something was said of the request, or for a while."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(POLL_SECONDS):
            async for change in changes:
                if change.request.id == request_id:
                    return
