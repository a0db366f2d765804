"""The open requests: what users post and take back, what the agent makes of them."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from rogue.conversation import announce
from rogue.memory import Facts, Step, Store
from rogue.messages import Closing, DeliveryRequest, Filled, RequestChanged, RequestState
from rogue.requests._directory import Directory
from rogue.requests._endings import Item, closes, ended
from tca_bus import Clock, Module

log = logging.getLogger(__name__)


class RequestBook:
    """All open requests in memory, as they stand on disk.

    ``changed`` is set whenever a request came, changed or ended; who waits on it clears it, and
    so with ``deadlines_changed`` and ``prospects_changed``. ``on_change`` is called then too.
    """

    def __init__(self, module: Module, store: Store, directory: Directory) -> None:
        self._module = module
        self._store = store
        self._directory = directory
        self._open: dict[str, DeliveryRequest] = {}
        self.on_change: Callable[[], None] = _nothing
        self.changed = asyncio.Event()
        self.deadlines_changed = asyncio.Event()
        self.prospects_changed = asyncio.Event()

    async def load(self) -> None:
        """Read what was open when the agent last ran."""
        self._open = {r.id: r for r in await self._store.requests(open_only=True)}
        self._wake()

    @property
    def clock(self) -> Clock:
        """The time of the world, in which requests are posted and end."""
        return self._module.clock

    def open_requests(self) -> list[DeliveryRequest]:
        """What is still to be done, the oldest first."""
        return list(self._open.values())

    def find(self, request_id: str) -> DeliveryRequest | None:
        """The open request of that id."""
        return self._open.get(request_id)

    def next_deadline(self) -> float | None:
        """The nearest deadline of an open request that is not given up already."""
        pending = (r.deadline for r in self._open.values() if r.closing is None)
        return min(pending, default=None)

    async def add(
        self, request: DeliveryRequest, why: str | None, filled: tuple[Filled, ...] = ()
    ) -> None:
        """Take on a request; it is on disk when this returns."""
        await self._store.add_request(request, why, filled)
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
        """The request as it is once it has ended; the reason says where its item is.

        One that was taken back while its item was on the tray ends as was decided then.
        """
        done = ended(request, state, reason, self._module.clock.now())
        reason = done.reason
        if reason and (request.user, request.item) in facts.tray:
            phrase = self._directory.phrase(request.user, request.item)
            reason = f"{reason}; {phrase} is still on the tray"
        return done.model_copy(update={"reason": reason})

    def as_given_up(
        self, request: DeliveryRequest, state: RequestState, reason: str, facts: Facts
    ) -> DeliveryRequest:
        """The request as it is once the robot has given up on it.

        An item that is on the tray goes back first, unless even that was tried in vain.
        """
        closing = Closing(state=state, reason=reason, since=self._module.clock.now())
        waits = closes(request, closing, "back", facts, None) if request.closing is None else None
        return waits or self.as_ended(request, state, reason, facts)

    def as_closed(self, request: DeliveryRequest, facts: Facts) -> DeliveryRequest:
        """A closing request as it is once there is nothing to wait for: it ends as was decided."""
        assert request.closing is not None
        return self.as_ended(request, request.closing.state, request.closing.reason, facts)

    def as_put_off(self, request: DeliveryRequest) -> DeliveryRequest:
        """The request as it is while it waits for a better time."""
        begun = request.state is RequestState.UNDERWAY
        return request.model_copy(update={"state": RequestState.SUSPENDED}) if begun else request

    async def suspend(self, request_id: str, reason: str) -> None:
        """Put a request aside that the robot has begun to serve; of others nothing changes."""
        request = self._open.get(request_id)
        if request is None or request.state is not RequestState.UNDERWAY:
            return
        changed = self.as_put_off(request)
        if await self._store.change_request(changed):
            await self._store.add_note(request_id, self._module.clock.now(), reason)
            await self.took_effect(changed)

    async def end(self, request: DeliveryRequest, state: RequestState, reason: str) -> bool:
        """End an open request from outside of a step; says whether it was still open."""
        ended = self.as_ended(request, state, reason, await self._store.facts())
        if not await self._store.change_request(ended, note=reason):
            return False
        await self.took_effect(ended)
        return True

    async def give_up(
        self, request_id: str, state: RequestState, reason: str, item: Item = "back"
    ) -> None:
        """Give up a request that is open.

        It ends at once, or stays open, closing, until its item has left the tray.
        """
        closing = Closing(state=state, reason=reason, since=self._module.clock.now())

        def decide(request: DeliveryRequest, facts: Facts, step: Step | None) -> DeliveryRequest:
            waits = closes(request, closing, item, facts, step)
            return waits or self.as_ended(request, state, reason, facts)

        changed = await self._store.withdraw(request_id, decide)
        if changed is not None:
            await self._take_over(changed)

    async def warn(self, request_id: str, warning: str | None) -> None:
        """Say what is to be feared for an open request; None: nothing any more."""
        known = self._open.get(request_id)
        if known is None:
            return
        now = self._module.clock.now()
        said = warning or "its deadline can be met again"
        if await self._store.warn(request_id, warning, note=said, time=now):
            log.info("request %s: %s", request_id, said)
            # It may have changed, or ended, while this was written.
            known = self._open.get(request_id)
            if known is not None:
                await self._take_over(known.model_copy(update={"warning": warning}))

    async def took_effect(self, request: DeliveryRequest) -> None:
        """Take over the state of a request that is on disk already, and tell of it."""
        known = self._open.get(request.id)
        if known is None or request.state.is_final:
            await self._take_over(request)
        else:
            # What came in meanwhile stands: that it closes, what is feared for it.
            fields: dict[str, object] = {"state": request.state}
            if known.closing is None:
                fields |= {"closing": request.closing, "then": request.then}
                fields |= {"pickup": request.pickup, "deliver": request.deliver}
            await self._take_over(known.model_copy(update=fields))

    async def _take_over(self, request: DeliveryRequest) -> None:
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
        self.prospects_changed.set()
        self.on_change()


def _nothing() -> None:
    """What is called at a change before anybody cares."""
