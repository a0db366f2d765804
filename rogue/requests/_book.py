"""The open requests: what users post and take back, what the agent makes of them."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from rogue.conversation import announce
from rogue.memory import Facts, Store
from rogue.messages import DeliveryRequest, RequestChanged, RequestState
from rogue.requests._directory import Directory
from tca_bus import Module

log = logging.getLogger(__name__)


class RequestBook:
    """All open requests in memory, as they stand on disk.

    ``changed`` is set whenever a request came or ended; who waits on it clears it, and so
    with ``deadlines_changed``. ``on_change`` is called then too.
    """

    def __init__(self, module: Module, store: Store, directory: Directory) -> None:
        self._module = module
        self._store = store
        self._directory = directory
        self._open: dict[str, DeliveryRequest] = {}
        self.on_change: Callable[[], None] = _nothing
        self.changed = asyncio.Event()
        self.deadlines_changed = asyncio.Event()

    async def load(self) -> None:
        """Read what was open when the agent last ran."""
        self._open = {r.id: r for r in await self._store.requests(open_only=True)}
        self._wake()

    def open_requests(self) -> list[DeliveryRequest]:
        """What is still to be done, the oldest first."""
        return list(self._open.values())

    def find(self, request_id: str) -> DeliveryRequest | None:
        """The open request of that id."""
        return self._open.get(request_id)

    def next_deadline(self) -> float | None:
        """The nearest deadline of an open request."""
        return min((request.deadline for request in self._open.values()), default=None)

    async def add(self, request: DeliveryRequest, why: str | None) -> None:
        """Take on a request; it is on disk when this returns."""
        await self._store.add_request(request, why)
        self._open[request.id] = request
        log.info(
            "request %s accepted: %s for %s, %s to %s",
            request.id,
            request.item,
            request.user,
            request.pickup,
            request.deliver,
        )
        self._wake()
        await announce(self._module, RequestChanged(request=request))

    def as_begun(self, request: DeliveryRequest) -> DeliveryRequest:
        """The request as it is once the robot serves it."""
        return request.model_copy(update={"state": RequestState.UNDERWAY})

    def as_ended(
        self, request: DeliveryRequest, state: RequestState, reason: str | None, facts: Facts
    ) -> DeliveryRequest:
        """The request as it is once it has ended; the reason says what is left on the tray."""
        if reason and (request.user, request.item) in facts.tray:
            phrase = self._directory.phrase(request.user, request.item)
            reason = f"{reason}; {phrase} is still on the tray"
        now = self._module.clock.now()
        return request.model_copy(update={"state": state, "reason": reason, "finished": now})

    async def end(self, request: DeliveryRequest, state: RequestState, reason: str) -> bool:
        """End an open request from outside of a step; says whether it was still open."""
        ended = self.as_ended(request, state, reason, await self._store.facts())
        if not await self._store.change_request(ended, note=reason):
            return False
        await self.took_effect(ended)
        return True

    async def took_effect(self, request: DeliveryRequest) -> None:
        """Take over a change that is on disk already, and tell of it."""
        if request.state.is_final:
            self._open.pop(request.id, None)
            why = f": {request.reason}" if request.reason else ""
            log.info("request %s %s%s", request.id, request.state, why)
        elif request.id in self._open:
            self._open[request.id] = request
        self._wake()
        await announce(self._module, RequestChanged(request=request))

    def _wake(self) -> None:
        self.changed.set()
        self.deadlines_changed.set()
        self.on_change()


def _nothing() -> None:
    """What is called at a change before anybody cares."""
