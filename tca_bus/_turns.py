"""The answering side of pools: places at handlers with a capacity, and the lines before them."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterable

from pydantic import Field

from tca_bus._context import Context
from tca_bus._core import Core
from tca_bus._errors import BusyError, RefusedError
from tca_bus._handlers import Handlers
from tca_bus._line import Line, Request, request_of
from tca_bus._messages import Query
from tca_bus._presence import PresenceChange


class AwaitTurn(Query[None]):
    """Caller to a module that was busy: answer when a place is kept for my request.

    ``request`` is the id under which the request ``message`` will come. The place is kept for a
    second.
    """

    wire_name = "tca.turn"

    message: str
    request: str = Field(min_length=1, max_length=200)


class WithdrawRequest(Query[None]):
    """Caller to a module: I do not wait for the answer to my request any more.

    It leaves the line, its place is free, and the handler of a `MultiQuery` is cancelled.
    """

    wire_name = "tca.withdraw"

    message: str
    request: str = Field(min_length=1, max_length=200)


class Turns:
    """The lines of one module, one for each handler that has a capacity."""

    def __init__(self, core: Core, handlers: Handlers, cancel: Callable[[Request], None]) -> None:
        self._core = core
        self._handlers = handlers
        self._cancel = cancel
        self._lines: dict[str, Line] = {}
        self._told: dict[Request, asyncio.Future[None]] = {}
        self._timer: asyncio.TimerHandle | None = None

    def begin(self) -> None:
        """Register the handlers of turns, and clear the lines of callers that die."""
        self._handlers.add(AwaitTurn, self._await_turn, built_in=True)
        self._handlers.add(WithdrawRequest, self._withdraw, built_in=True)
        self._core.presence.listen(self._presence_changed)

    def enter(self, name: str, request: Request) -> bool:
        """Whether a request may be handled now; if so it has to `leave`."""
        line = self._line(name)
        return line is None or line.enter(request)

    def leave(self, name: str, request: Request) -> None:
        """A request is done: the next one in line has its place."""
        line = self._line(name)
        if line is not None:
            self._tell(line.leave(request, self._now()))

    async def _await_turn(self, question: AwaitTurn, context: Context) -> None:
        line = self._line(question.message)
        if line is None:
            return
        if line.is_full:
            module = f"module {self._core.name!r}"
            raise BusyError(question.message, f"{module} has {line.waiting} waiting already")
        request = request_of(context.sender, question.message, question.request)
        turn = self._told.setdefault(request, asyncio.get_running_loop().create_future())
        self._tell(line.wait(request, self._now()))
        try:
            await asyncio.shield(turn)
        finally:
            self._told.pop(request, None)

    async def _withdraw(self, order: WithdrawRequest, context: Context) -> None:
        self._clear(order.message, request_of(context.sender, order.message, order.request))

    def _clear(self, name: str, request: Request) -> None:
        self._cancel(request)
        line = self._line(name)
        if line is not None:
            self._tell(line.withdraw(request, self._now()))
        turn = self._told.pop(request, None)
        if turn is not None and not turn.done():
            turn.set_exception(RefusedError(name, "its caller withdrew it"))

    def _presence_changed(self, change: PresenceChange) -> None:
        caller = change.module.name
        if change.appeared or self._core.presence.table.named(caller) is not None:
            return
        for name, line in self._lines.items():
            for request in line.waiting_of(caller):
                self._clear(name, request)

    def _tell(self, placed: Iterable[Request]) -> None:
        for request in placed:
            turn = self._told.get(request)
            if turn is not None and not turn.done():
                turn.set_result(None)
        self._set_timer()

    def _set_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        due = min((line.next_expiry() for line in self._lines.values()), default=math.inf)
        if due < math.inf:
            self._timer = asyncio.get_running_loop().call_at(due, self._expire)

    def _expire(self) -> None:
        self._timer = None
        self._tell([one for line in self._lines.values() for one in line.expire(self._now())])

    def _line(self, name: str) -> Line | None:
        """The line of a handler, None if it takes as many as come."""
        line = self._lines.get(name)
        if line is None:
            handler = self._handlers.get(name)
            if handler is None or handler.capacity is None or not handler.is_query:
                return None
            line = self._lines[name] = Line(handler.capacity)
        return line

    def _now(self) -> float:
        return asyncio.get_running_loop().time()
