"""The answering side of queries: every query that arrives is answered, once per request id."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

import zenoh
from pydantic import ValidationError

from tca_bus._answers import AnswerCache
from tca_bus._bridge import Answer, attachment_of, payload_of, query_payload
from tca_bus._context import Context
from tca_bus._core import Core
from tca_bus._envelope import INCARNATION_PATTERN, Envelope, begin_handling, read_envelope
from tca_bus._errors import (
    AtCapacityError,
    BusyError,
    HandlerFailedError,
    InvalidMessageError,
    NoHandlerError,
    TaskError,
    TaskFailedError,
)
from tca_bus._faults import FAILURE_NAMES, encode_error
from tca_bus._handlers import Handler, Handlers
from tca_bus._keys import QueryAddress, parse_query, parse_sender
from tca_bus._line import Request, request_of
from tca_bus._messages import Message, MessageClass
from tca_bus._problems import problems_of
from tca_bus._replies import PublishedAnswer, WayBack, ZenohReply
from tca_bus._rights import Right
from tca_bus._turns import Turns
from tca_bus._types import answer_adapter
from tca_bus._wire import Payload, decode_message, encode_answer, told_revision

MOST_WAITING = 1024
"""Queries that wait for the loop; more are answered with 'busy' on Zenoh's thread."""

MOST_RUNNING = 1024
"""Queries that one handler works on at once; more of them are answered with 'busy'."""

EXPECTED = (*FAILURE_NAMES, HandlerFailedError, TaskError, TaskFailedError)
"""What a handler may end with as part of its work; anything else is logged with its trace."""


class ContextFactory(Protocol):
    """Makes the context of a handled message."""

    def __call__(self, *, sender: str, id: str) -> Context:
        """Make it."""
        ...


class _Running(NamedTuple):
    """A request that is being handled: by which task, and who waits for its answer."""

    task: asyncio.Task[None]
    ways: list[WayBack]


class QueryServer:
    """Answers the queries to one module; its handlers run concurrently."""

    def __init__(self, core: Core, handlers: Handlers, context: ContextFactory) -> None:
        self._core = core
        self._handlers = handlers
        self._context = context
        self._cache = AnswerCache()
        self._running: dict[Request, _Running] = {}
        self._under_way: dict[str, int] = {}
        self._turns = Turns(core, handlers, self._cancel_survey)
        self._loop = asyncio.get_running_loop()
        self._broken: asyncio.Future[None] = self._loop.create_future()
        self._is_closing = False

    def begin(self) -> None:
        """Declare the subscriber of published queries and the queryable of Zenoh's own."""
        core = self._core
        self._turns.begin()
        calls, post_call = core.session.mailbox(
            self._take_call, size=MOST_WAITING, refuse=self._refuse_call
        )
        core.tally.counters["call"] = lambda: calls.dropped
        key = core.keys.calls_to(core.name, core.incarnation)
        core.session.declare_subscriber(key, post_call)
        queries, post_query = core.session.mailbox(
            self._take_query, size=MOST_WAITING, refuse=self._refuse_query
        )
        core.tally.counters["query"] = lambda: queries.dropped
        key = core.keys.queries_to(core.name, core.incarnation)
        core.session.declare_queryable(key, post_query)
        core.spawn(self._keep_handlers(), name=f"{core.name}.queries")

    async def _keep_handlers(self) -> None:
        """Own the tasks of the handlers: one task for all, as a query's may take microseconds."""
        try:
            await self._broken
        finally:
            self._is_closing = True
            tasks = [running.task for running in self._running.values()]
            for task in tasks:
                task.cancel()
            if tasks:
                await asyncio.wait(tasks)

    def _take_call(self, sample: zenoh.Sample) -> None:
        try:
            address, envelope = _read_call(sample)
        except InvalidMessageError as error:
            # Without an envelope there is no way back to whoever sent it.
            self._core.tally.note_invalid(error, sender=parse_sender(str(sample.key_expr)))
            return
        way = PublishedAnswer(self._core, address.caller, envelope.sender, envelope.id)
        self._take(way, address, envelope, payload_of(sample))

    def _take_query(self, query: zenoh.Query) -> None:
        try:
            address = parse_query(str(query.key_expr))
            envelope = read_envelope(attachment_of(query))
        except (InvalidMessageError, ValueError) as error:
            self._reject(query, error)
            return
        way = ZenohReply(self._core, query, address)
        self._take(way, address, envelope, query_payload(query))

    def _take(
        self, way: WayBack, address: QueryAddress, envelope: Envelope, payload: Payload
    ) -> None:
        """Start handling a request, or answer it at once."""
        name = address.name
        request = request_of(address.caller, name, envelope.id)
        known = self._cache.get(request)
        if known is not None:
            way.send(known)
        elif request in self._running:
            self._running[request].ways.append(way)
        elif self._is_closing:
            way.drop()
        elif self._under_way.get(name, 0) >= MOST_RUNNING:
            self._refuse_more(way, name)
        elif not self._turns.enter(name, request):
            way.send(self._error_answer(self._at_capacity(name), name))
        else:
            self._begin_work(way, request, address, envelope, payload)

    def _begin_work(
        self,
        way: WayBack,
        request: Request,
        address: QueryAddress,
        envelope: Envelope,
        payload: Payload,
    ) -> None:
        ways = [way]
        work = self._work(request, ways, address, envelope, payload)
        task = self._loop.create_task(work, name=f"{self._core.name}.query.{address.name}")
        self._running[request] = _Running(task, ways)
        self._under_way[address.name] = self._under_way.get(address.name, 0) + 1
        if self._is_survey(address.name):
            # One that is cancelled before its first step never comes to its own end.
            task.add_done_callback(lambda done: self._finish(request, address.name, done))

    async def _work(
        self,
        request: Request,
        ways: list[WayBack],
        address: QueryAddress,
        envelope: Envelope,
        payload: Payload,
    ) -> None:
        try:
            begin_handling(envelope)
            answer = await self._answer(address, envelope, payload)
            self._cache.put(request, answer)
            for way in ways:
                way.send(answer)
        except Exception as error:
            # No handler's, those are answers: it ends the module.
            if not self._broken.done():
                self._broken.set_exception(error)
        finally:
            self._finish(request, address.name, asyncio.current_task())

    def _finish(self, request: Request, name: str, task: asyncio.Task[None] | None) -> None:
        """Let go of a request, if it is still handled by the task."""
        running = self._running.get(request)
        if running is None or running.task is not task:
            return
        del self._running[request]
        for way in running.ways:
            way.drop()
        left = self._under_way.pop(name) - 1
        if left:
            self._under_way[name] = left
        self._turns.leave(name, request)

    def _is_survey(self, name: str) -> bool:
        handler = self._handlers.get(name)
        return (
            handler is not None and handler.message_type.message_class is MessageClass.MULTI_QUERY
        )

    def _cancel_survey(self, request: Request) -> None:
        running = self._running.get(request)
        if running is not None and self._is_survey(request[1].partition("/")[0]):
            running.task.cancel()

    async def _answer(self, address: QueryAddress, envelope: Envelope, payload: Payload) -> Answer:
        try:
            self._core.permissions.check(address.caller, Right.SEND, address.name)
            handler = self._find(address.name)
            message = decode_message(payload, handler.message_type)
            told = told_revision(payload)
            context = self._context(sender=address.caller, id=envelope.id)
            if handler.resource is None or address.caller == self._core.name:
                # A module that asks itself may have the place already.
                value = await self._run(handler, message, context)
            else:
                async with self._handlers.place(handler):
                    value = await self._run(handler, message, context)
            return self._checked(_answer_of(value, handler.message_type, told), address.name)
        except Exception as error:
            self._note(error, address)
            return self._error_answer(error, address.name)

    def _checked(self, answer: Answer, name: str) -> Answer:
        """The answer, if it is not bigger than it may be."""
        self._core.permissions.check_answer(self._core.name, name, len(answer.payload.data))
        return answer

    def _run(self, handler: Handler, message: Message, context: Context) -> Awaitable[Any]:
        tapping = self._core.tapping
        if tapping.is_tapped(handler.name):
            return tapping.call(handler, message, context)
        return handler.call(message, context)

    def _find(self, name: str) -> Handler:
        handler = self._handlers.get(name)
        if handler is None or not handler.is_query:
            known = {h.message_type.wire_name for h in self._handlers}
            raise NoHandlerError(name, known)
        if self._handlers.is_held and not handler.built_in:
            raise BusyError(name, f"module {self._core.name!r} is not ready yet")
        return handler

    def _note(self, error: Exception, address: QueryAddress) -> None:
        if isinstance(error, InvalidMessageError):
            self._core.tally.note_invalid(error, sender=address.caller)
        elif not isinstance(error, EXPECTED):
            cause = f"handler of {address.name}: {type(error).__name__}"
            text = f"handler of {address.name} failed"
            self._core.tally.complain(cause, text, error=error)

    def _reject(self, query: zenoh.Query, error: ValueError) -> None:
        if not isinstance(error, InvalidMessageError):
            error = InvalidMessageError("query", [str(error)])
        self._core.tally.note_invalid(error, sender=parse_sender(str(query.key_expr)))
        self._reply_error(query, self._error_answer(error, "query"))

    def _refuse_more(self, way: WayBack, name: str) -> None:
        running = self._under_way.get(name, 0)
        text = f"handler of {name} has {running} queries under way: more are refused"
        self._core.tally.complain(f"too many {name}", text)
        way.send(self._busy())

    def _refuse_query(self, query: zenoh.Query) -> None:
        self._reply_error(query, self._busy())

    def _refuse_call(self, sample: zenoh.Sample) -> None:
        """Say on Zenoh's thread that there is no room; outlets belong to the loop's."""
        try:
            address, envelope = _read_call(sample)
        except InvalidMessageError:
            return
        core = self._core
        key = core.keys.answer(address.caller, envelope.sender, core.name)
        core.session.put(key, self._busy().payload, attachment=envelope.id.encode(), block=True)

    def _busy(self) -> Answer:
        error = BusyError("the query", f"module {self._core.name!r} has too many waiting")
        return self._error_answer(error, "query")

    def _at_capacity(self, name: str) -> AtCapacityError:
        return AtCapacityError(name, f"module {self._core.name!r} has no place free; ask again")

    def _error_answer(self, error: Exception, message: str) -> Answer:
        payload = encode_error(error, message=message, module=self._core.name)
        return Answer(payload, is_error=True)

    def _reply_error(self, query: zenoh.Query, answer: Answer) -> None:
        with query:
            query.reply_err(answer.payload.data, encoding=answer.payload.encoding)


def _answer_of(value: Any, message_type: type[Message], told: int | None) -> Answer:
    """Encode what a handler returned, in the form for a sender of revision ``told``.

    Raises:
        TaskError: It is not what the message names as its answer.
    """
    adapter = answer_adapter(message_type)
    try:
        checked = adapter.validate_python(value)
    except ValidationError as error:
        raise TaskError("invalid_answer", f"answer: {'; '.join(problems_of(error))}") from error
    return Answer(encode_answer(checked, adapter, message_type, told=told), is_error=False)


def _read_call(sample: zenoh.Sample) -> tuple[QueryAddress, Envelope]:
    """Read where a published query comes from.

    Raises:
        InvalidMessageError: Its attachment does not say where the answer goes.
    """
    envelope = read_envelope(attachment_of(sample) or b"")
    if not _is_incarnation(envelope.sender):
        problem = f"sender: expected an incarnation, got {envelope.sender[:100]!r}"
        raise InvalidMessageError("attachment", [problem])
    return parse_query(str(sample.key_expr)), envelope


@lru_cache(maxsize=1024)
def _is_incarnation(text: str) -> bool:
    return INCARNATION_PATTERN.fullmatch(text) is not None
