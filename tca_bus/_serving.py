"""The answering side of queries: every query that arrives is answered, once per request id."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import Counter
from typing import Protocol

import zenoh
from pydantic import ValidationError
from zenoh.handlers import Callback

from tca_bus._answers import AnswerCache
from tca_bus._bridge import Answer, Mailbox, attachment_of, query_payload
from tca_bus._context import Context
from tca_bus._core import Core
from tca_bus._envelope import Envelope, begin_handling, read_envelope
from tca_bus._errors import (
    AtCapacityError,
    BusyError,
    ClosedError,
    HandlerFailedError,
    InvalidMessageError,
    NoHandlerError,
    TaskError,
    TaskFailedError,
)
from tca_bus._faults import FAILURE_NAMES, encode_error
from tca_bus._handlers import QUERIES, Handler, Handlers
from tca_bus._keys import QueryAddress, parse_query, parse_sender
from tca_bus._line import Request, request_of
from tca_bus._messages import Message, MessageClass
from tca_bus._presence import PresentModule
from tca_bus._problems import problems_of
from tca_bus._rights import Right
from tca_bus._turns import Turns
from tca_bus._types import answer_adapter
from tca_bus._wire import Payload, decode_message, encode_answer, told_revision

logger = logging.getLogger(__name__)

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


class QueryServer:
    """Answers the queries to one module; its handlers run concurrently."""

    def __init__(self, core: Core, handlers: Handlers, context: ContextFactory) -> None:
        self._core = core
        self._handlers = handlers
        self._context = context
        self._cache = AnswerCache()
        self._running: dict[Request, list[zenoh.Query]] = {}
        self._under_way: Counter[str] = Counter()
        self._surveys: dict[Request, asyncio.Task[None]] = {}
        self._turns = Turns(core, handlers, self._cancel_survey)

    def begin(self) -> None:
        """Declare the queryable."""
        self._turns.begin()
        box = Mailbox[zenoh.Query](self._take, size=MOST_WAITING, refuse=self._refuse_busy)
        self._core.tally.counters["query"] = lambda: box.dropped
        key = self._core.keys.queries_to(self._core.name, self._core.incarnation)
        self._core.session.zenoh.declare_queryable(key, Callback(box.post))

    def _take(self, query: zenoh.Query) -> None:
        """Start handling a query, or answer it at once."""
        try:
            address = parse_query(str(query.key_expr))
            envelope = read_envelope(attachment_of(query))
        except (InvalidMessageError, ValueError) as error:
            self._reject(query, error)
            return
        request = request_of(address.caller, address.name, envelope.id)
        known = self._cache.get(request)
        if known is not None:
            self._send(query, address, known)
        elif request in self._running:
            self._running[request].append(query)
        elif self._under_way[address.name] >= MOST_RUNNING:
            self._refuse_more(query, address.name)
        elif not self._turns.enter(address.name, request):
            self._reply_error(query, self._at_capacity(address.name))
        else:
            self._begin_work(query, request, address, envelope)

    def _begin_work(
        self, query: zenoh.Query, request: Request, address: QueryAddress, envelope: Envelope
    ) -> None:
        work = self._work(request, address, envelope, query_payload(query))
        try:
            task = self._core.spawn(work, name=f"{self._core.name}.query.{address.name}")
        except ClosedError:
            query.drop()
            return
        self._running[request] = [query]
        self._under_way[address.name] += 1
        task.add_done_callback(lambda _: self._finish(request, address.name))
        handler = self._handlers.get(address.name)
        if handler is not None and handler.message_type.message_class == MessageClass.MULTI_QUERY:
            self._surveys[request] = task

    async def _work(
        self, request: Request, address: QueryAddress, envelope: Envelope, payload: Payload
    ) -> None:
        begin_handling(envelope)
        answer = await self._answer(address, envelope, payload)
        self._cache.put(request, answer)
        for query in self._running[request]:
            self._send(query, address, answer)

    def _finish(self, request: Request, name: str) -> None:
        """Let go of a request, also of one whose work was cancelled before its first step."""
        for query in self._running.pop(request):
            query.drop()
        self._surveys.pop(request, None)
        self._under_way[name] -= 1
        if not self._under_way[name]:
            del self._under_way[name]
        self._turns.leave(name, request)

    def _cancel_survey(self, request: Request) -> None:
        task = self._surveys.get(request)
        if task is not None:
            task.cancel()

    async def _answer(self, address: QueryAddress, envelope: Envelope, payload: Payload) -> Answer:
        try:
            self._core.permissions.check(address.caller, Right.SEND, address.name)
            handler = self._find(address.name)
            message = decode_message(payload, handler.message_type)
            told = told_revision(payload)
            return await self._handle(handler, message, address, envelope, told)
        except Exception as error:
            self._note(error, address)
            payload = encode_error(error, message=address.name, module=self._core.name)
            return Answer(payload, is_error=True)

    async def _handle(
        self,
        handler: Handler,
        message: Message,
        address: QueryAddress,
        envelope: Envelope,
        told: int | None,
    ) -> Answer:
        context = self._context(sender=address.caller, id=envelope.id)
        async with self._place(handler, address):
            value = await self._core.tapping.call(handler, message, context)
        adapter = answer_adapter(handler.message_type)
        try:
            checked = adapter.validate_python(value)
        except ValidationError as error:
            raise TaskError("invalid_answer", f"answer: {'; '.join(problems_of(error))}") from error
        answer = encode_answer(checked, adapter, handler.message_type, told=told)
        self._core.permissions.check_answer(self._core.name, address.name, len(answer.data))
        return Answer(answer, is_error=False)

    def _place(
        self, handler: Handler, address: QueryAddress
    ) -> contextlib.AbstractAsyncContextManager[None]:
        """A place in the handler's resource; a module that asks itself may have it already."""
        if address.caller == self._core.name:
            return contextlib.nullcontext()
        return self._handlers.turn(handler)

    def _find(self, name: str) -> Handler:
        handler = self._handlers.get(name)
        if handler is None or handler.message_type.message_class not in QUERIES:
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
        self._reply_error(query, error)

    def _refuse_more(self, query: zenoh.Query, name: str) -> None:
        text = f"handler of {name} has {self._under_way[name]} queries under way: more are refused"
        self._core.tally.complain(f"too many {name}", text)
        self._refuse_busy(query)

    def _refuse_busy(self, query: zenoh.Query) -> None:
        name = f"module {self._core.name!r}"
        self._reply_error(query, BusyError("the query", f"{name} has too many waiting"))

    def _at_capacity(self, name: str) -> AtCapacityError:
        return AtCapacityError(name, f"module {self._core.name!r} has no place free; ask again")

    def _reply_error(self, query: zenoh.Query, error: Exception) -> None:
        payload = encode_error(error, message="query", module=self._core.name)
        with query:
            query.reply_err(payload.data, encoding=payload.encoding)

    def _send(self, query: zenoh.Query, address: QueryAddress, answer: Answer) -> None:
        data, encoding = answer.payload.data, answer.payload.encoding
        try:
            with query:
                if answer.is_error:
                    query.reply_err(data, encoding=encoding)
                else:
                    query.reply(self._reply_key(query, address), data, encoding=encoding)
        except zenoh.ZError as error:
            logger.warning("answer to %s was not sent: %s", address.caller, error)

    def _reply_key(self, query: zenoh.Query, address: QueryAddress) -> str | zenoh.KeyExpr:
        """A concrete key: a tool may have asked with wildcards."""
        if "*" not in str(query.key_expr):
            return query.key_expr
        core = self._core
        me = PresentModule(core.name, core.incarnation, "", 0, ())
        return core.keys.query(me, address.name, address.caller.replace("*", "anonymous"))
