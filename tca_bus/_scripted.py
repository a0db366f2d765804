"""A module for tests that answers as told."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from types import TracebackType
from typing import Any, Generic, Self, TypeVar

from pydantic import ValidationError

from tca_bus._context import Context
from tca_bus._errors import InvalidMessageError, TaskError, TcaError
from tca_bus._messages import Broadcast, Inform, Message, MultiQuery, Query, TaskMessage
from tca_bus._module import Module
from tca_bus._options import BusOptions
from tca_bus._problems import problems_of
from tca_bus._types import answer_adapter
from tca_bus._wire import REPLY_SUFFIX

M = TypeVar("M", bound=Message)
R = TypeVar("R")

Answered = type[Query[R]] | type[MultiQuery[R]] | type[TaskMessage[R]]
Line = Callable[[Any], Awaitable[Any]]


@dataclass(frozen=True, slots=True)
class Call(Generic[M]):
    """One message that a scripted module was given.

    ``attempt`` counts how often a goal or command was given to a handler; 1 for all others.
    """

    message: M
    sender: str
    id: str
    attempt: int


class Hold(Generic[R]):
    """A line of a script at which the handler waits until the test lets it go."""

    def __init__(self, check: Callable[[Any], Any]) -> None:
        self._check = check
        self._reached = asyncio.Event()
        self._outcome: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

    async def reached(self, *, timeout: float = 10.0) -> None:
        """Wait until a handler waits here.

        Raises:
            AssertionError: None does within ``timeout`` wall seconds.
        """
        try:
            async with asyncio.timeout(timeout):
                await self._reached.wait()
        except TimeoutError as error:
            raise AssertionError(f"no message came within {timeout:g} s") from error

    def release(self, answer: R) -> None:
        """Let those go that wait here, and those that come, with this answer."""
        self._settle(lambda outcome: outcome.set_result(self._check(answer)))

    def fail(self, error: TaskError | TcaError) -> None:
        """Let those go that wait here, and those that come, with this failure."""
        self._settle(lambda outcome: outcome.set_exception(error))

    def _settle(self, settle: Callable[[asyncio.Future[Any]], None]) -> None:
        if self._outcome.done():
            raise AssertionError("what is held here was let go before")
        settle(self._outcome)
        self._outcome.exception()

    async def wait(self, _: Any) -> Any:
        """Wait as the handler."""
        self._reached.set()
        return await asyncio.shield(self._outcome)


@dataclass
class _Script:
    """What is done with the messages of one type."""

    lines: list[Line] = field(default_factory=list)
    calls: list[Call[Any]] = field(default_factory=list)
    cancelled: list[Any] = field(default_factory=list)


class ScriptedModule:
    """A module that answers as told and remembers what it was sent: an async context manager.

    The lines of a message type are followed one message after the other; the last one stays. They
    may be given before and after entering.
    """

    def __init__(
        self,
        name: str,
        *,
        options: BusOptions,
        provides: Iterable[str] = (),
        requires: Iterable[str] = (),
    ) -> None:
        self.module = Module(name, options=options, provides=provides, requires=requires)
        self._scripts: dict[type[Message], _Script] = {}
        self._news: dict[type[Message], asyncio.Event] = defaultdict(asyncio.Event)

    async def __aenter__(self) -> Self:
        await self.module.__aenter__()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.module.__aexit__(kind, error, trace)

    def answers(self, message_type: Answered[R], *answers: R) -> Self:
        """Answer with these, one after the other; the last one stays.

        Raises:
            InvalidMessageError: One does not fit the message type.
        """
        for answer in answers:
            checked = _check(message_type, answer)
            self._add(message_type, partial(_give, checked))
        return self

    def fails(self, message_type: Answered[Any], *errors: TaskError | TcaError) -> Self:
        """Fail with these, one after the other; the last one stays."""
        for error in errors:
            self._add(message_type, partial(_fail, error))
        return self

    def computes(self, message_type: type[M], function: Callable[[M], Awaitable[Any]]) -> Self:
        """Answer with what an async function makes of the message."""
        self._add(message_type, function)
        return self

    def holds(self, message_type: Answered[R]) -> Hold[R]:
        """Hold the next message until the test lets it go."""
        hold = Hold[R](lambda answer: _check(message_type, answer))
        self._add(message_type, hold.wait)
        return hold

    def hears(self, *message_types: type[Inform | Broadcast]) -> Self:
        """Take one-way messages and remember them."""
        for kind in message_types:
            self._add(kind, partial(_give, None))
        return self

    def calls(self, message_type: type[M]) -> list[Call[M]]:
        """What came of a type, with who sent it, the oldest first."""
        return list(self._script(message_type).calls)

    def received(self, message_type: type[M]) -> list[M]:
        """The messages that came of a type, the oldest first."""
        return [call.message for call in self.calls(message_type)]

    def cancelled(self, message_type: type[M]) -> list[M]:
        """The messages whose handlers were cancelled: killed, withdrawn, or at the end."""
        return list(self._script(message_type).cancelled)

    async def receives(
        self, message_type: type[M], count: int = 1, *, timeout: float = 10.0
    ) -> list[M]:
        """Wait until so many messages of a type have come since the beginning; gives them.

        Raises:
            AssertionError: Not within ``timeout`` wall seconds.
        """
        try:
            async with asyncio.timeout(timeout):
                while len(found := self.received(message_type)) < count:
                    self._news[message_type].clear()
                    await self._news[message_type].wait()
        except TimeoutError as error:
            name, had = message_type.wire_name, len(found)
            sentence = f"{had} of {count} {name!r} came within {timeout:g} s"
            raise AssertionError(sentence) from error
        return found

    async def vanish(self) -> None:
        """Leave the bus as a process does that is killed: at once and without a word."""
        await lose(self.module)

    def _script(self, message_type: type[Message]) -> _Script:
        return self._scripts.setdefault(message_type, _Script())

    def _add(self, message_type: type[Message], line: Line) -> None:
        is_new = message_type not in self._scripts
        self._script(message_type).lines.append(line)
        if is_new:
            self.module.serve(message_type, self._handle)

    async def _handle(self, message: Any, context: Context) -> Any:
        kind = type(message)
        script = self._script(kind)
        line = script.lines[min(len(script.calls), len(script.lines) - 1)]
        attempt = getattr(context, "attempt", 1)
        script.calls.append(Call(message, context.sender, context.id, attempt))
        self._news[kind].set()
        try:
            return await line(message)
        except asyncio.CancelledError:
            script.cancelled.append(message)
            raise


def _check(message_type: type[Message], answer: Any) -> Any:
    try:
        return answer_adapter(message_type).validate_python(answer)
    except ValidationError as error:
        raise InvalidMessageError(
            message_type.wire_name + REPLY_SUFFIX, problems_of(error)
        ) from error


async def lose(module: Module) -> None:
    """Close the session of a module under it, as the end of its process does."""
    await module._parts.core.session.close()  # noqa: SLF001 - no program but a test does this


async def _give(value: Any, _message: Any) -> Any:
    return value


async def _fail(error: Exception, _message: Any) -> Any:
    raise error
