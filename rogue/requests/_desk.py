"""What the rogue module answers on the bus."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from weakref import WeakValueDictionary

from rogue.deadlines import read_moment
from rogue.errors import IdTakenError, RequestError, UnknownRequestError
from rogue.memory import Store
from rogue.messages import (
    CancelRequest,
    DeliveryRequest,
    ListRequests,
    PostRequest,
    ReadTrace,
    Refusal,
    RequestDetails,
    RequestState,
    ShowRequest,
    TraceLine,
    Why,
    WhyReport,
)
from rogue.requests._book import RequestBook
from rogue.requests._endings import is_carried
from rogue.requests._intake import is_same_errand, normal, refuse_duplicate
from rogue.requests._prospects import Prospects
from rogue.requests._reception import Reception
from rogue.requests._why import why_report
from tca_bus import Context, Module, TaskError, TcaError

READY_WAIT = 5.0
"""Wall seconds that a request waits for the robot's time to be known."""

RoomSource = Callable[[], Awaitable[dict[str, tuple[float, float]]]]
"""Gives all rooms of the map."""


class Desk:
    """Handlers of the messages in `rogue.messages`."""

    def __init__(
        self,
        module: Module,
        store: Store,
        book: RequestBook,
        reception: Reception,
        prospects: Prospects,
    ) -> None:
        self._module = module
        self._store = store
        self._book = book
        self._reception = reception
        self._prospects = prospects
        self._accepting = asyncio.Lock()
        self._turns: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    def open(self, rooms: RoomSource) -> None:
        """Register all handlers; ``rooms`` is asked at each new request."""
        self._rooms = rooms
        self._module.serve(PostRequest, self._post)
        self._module.serve(CancelRequest, self._cancel)
        self._module.serve(ListRequests, self._list)
        self._module.serve(ShowRequest, self._show)
        self._module.serve(ReadTrace, self._trace)
        self._module.serve(Why, self._why)

    async def _post(self, message: PostRequest, context: Context) -> DeliveryRequest:
        del context
        # One that is posted again, while what it lacks is asked for, waits for the first.
        async with self._turns.setdefault(message.id, asyncio.Lock()):
            try:
                return await self._posted(message) or await self._accept(message)
            except RequestError as error:
                raise error.as_task_error() from error

    async def _accept(self, message: PostRequest) -> DeliveryRequest:
        rooms = await self._known_rooms()
        now = self._module.clock.now()
        request, filled = await self._reception.complete(message, rooms=rooms, now=now)
        await self._prospects.get_ready(request)
        async with self._accepting:
            if not message.again:
                refuse_duplicate(request, self._book.open_requests())
            if not message.anyway:
                request, filled = await self._prospects.in_time(request, filled)
            await self._book.add(request, message.why, filled)
            await self._prospects.review()
        return self._book.find(request.id) or request

    async def _posted(self, message: PostRequest) -> DeliveryRequest | None:
        """The request that was made of the message when it came before."""
        known = await self._store.request(message.id)
        if known is not None and not is_same_errand(message, known):
            raise IdTakenError(message.id)
        return known

    async def _cancel(self, message: CancelRequest, context: Context) -> DeliveryRequest:
        del context
        request = await self._find(message.id)
        if not request.state.is_final:
            with self._module.clock.hold():
                await self._book.give_up(
                    request.id, RequestState.CANCELED, message.reason, message.item
                )
        return await self._find(message.id)

    async def _list(self, message: ListRequests, context: Context) -> list[DeliveryRequest]:
        del context
        return await self._store.requests(
            open_only=message.open_only,
            states=message.states,
            user=normal(message.user) if message.user else None,
            most=message.most,
        )

    async def _show(self, message: ShowRequest, context: Context) -> RequestDetails:
        del context
        request = await self._find(message.id)
        facts = await self._store.facts()
        return RequestDetails(
            request=request,
            why=await self._store.why(request.id),
            filled=await self._store.filled(request.id),
            on_tray=is_carried(request, facts),
            steps=await self._store.steps_of(request.id),
        )

    async def _trace(self, message: ReadTrace, context: Context) -> list[TraceLine]:
        del context
        try:
            since = read_moment(message.since, self._module.clock.now()) if message.since else None
        except RequestError as error:
            raise error.as_task_error() from error
        return await self._store.lines(message.after, message.most, since=since)

    async def _why(self, message: Why, context: Context) -> WhyReport:
        del context
        request = await self._find(message.id)
        now = self._module.clock.now()
        others = self._book.open_requests()
        return await why_report(self._store, request, others, now, everything=message.everything)

    async def _find(self, request_id: str) -> DeliveryRequest:
        request = await self._store.request(request_id)
        if request is None:
            raise UnknownRequestError(request_id, await self._store.latest_ids()).as_task_error()
        return request

    async def _known_rooms(self) -> dict[str, tuple[float, float]]:
        try:
            await self._module.clock.wait_ready(READY_WAIT)
            return await self._rooms()
        except TcaError as error:
            raise TaskError(
                Refusal.NOT_READY, f"the robot that knows time and rooms is not there: {error}"
            ) from error
