"""Queries to all modules that handle a message."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable
from typing import Any, Generic, Self, TypeVar

from tca_bus._caller import Caller
from tca_bus._errors import ConfigError, NoHandlerError, TcaError, TimedOutError
from tca_bus._messages import MultiQuery
from tca_bus._presence import PresentModule
from tca_bus._rights import Right
from tca_bus._types import answer_adapter
from tca_bus._wire import decode_answer, encode_message

R = TypeVar("R")


class Answers(Generic[R]):
    """The answers to a query to all, fastest first: an async iterator, asked on the first step.

    Ends after ``most`` answers, when all have answered or failed, or after ``timeout`` wall
    seconds, whichever comes first. One that fails keeps nobody else from answering: it stands in
    ``failed``. What is not waited for any more is withdrawn, and its handler cancelled; to leave
    early, break off inside ``async with``.

    Raises:
        NoHandlerError: From the first step, no module here handles the message.
        RefusedError: From the first step, this module may not send it.
        TimedOutError: At the end, nobody had answered or failed by then.
        ExceptionGroup: At the end, nobody answered; it has what they failed with.
    """

    def __init__(
        self,
        caller: Callable[[], Caller],
        message: MultiQuery[R],
        *,
        most: int | None,
        timeout: float,
    ) -> None:
        if most is not None and most < 1:
            raise ConfigError("most", most, "at least 1 answer, or None for all")
        self.asked: tuple[str, ...] = ()
        """The names of the modules that were asked."""
        self.answered: list[str] = []
        """The names of those whose answers came out, in that order."""
        self.failed: dict[str, TcaError] = {}
        """What those that gave no answer failed with, by their names."""
        self._caller = caller
        self._message = message
        self._most = most
        self._timeout = timeout
        self._answers = self._run()

    @property
    def missing(self) -> tuple[str, ...]:
        """The names of those that have neither answered nor failed."""
        known = {*self.answered, *self.failed}
        return tuple(name for name in self.asked if name not in known)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> R:
        return await anext(self._answers)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """Wait for no more answers."""
        await self._answers.aclose()

    async def _run(self) -> AsyncGenerator[R, None]:
        caller = self._caller()
        questions = {self._ask(caller, one): one.name for one in self._providers(caller)}
        self.asked = tuple(questions.values())
        deadline = asyncio.get_running_loop().time() + self._timeout
        waiting = set(questions)
        try:
            while waiting and len(self.answered) != self._most:
                left = deadline - asyncio.get_running_loop().time()
                done, waiting = await asyncio.wait(
                    waiting, timeout=max(left, 0.0), return_when=asyncio.FIRST_COMPLETED
                )
                if not done:
                    break
                for question in sorted(done, key=lambda one: one.get_name()):
                    name = questions[question]
                    error = question.exception()
                    if error is None and len(self.answered) != self._most:
                        self.answered.append(name)
                        yield question.result()
                    elif isinstance(error, TcaError):
                        self.failed[name] = error
                    elif error is not None:
                        raise error
        finally:
            for question in questions:
                question.cancel()
            await asyncio.gather(*questions, return_exceptions=True)
        self._complain()

    def _providers(self, caller: Caller) -> list[PresentModule]:
        name = self._message.wire_name
        caller.core.permissions.check(caller.core.name, Right.SEND, name)
        table = caller.core.presence.table
        providers = table.providers(name)
        if not providers:
            raise NoHandlerError(name, table.known_messages())
        return providers

    def _ask(self, caller: Caller, to: PresentModule) -> asyncio.Task[R]:
        asking = _ask(caller, self._message, to)
        return asyncio.create_task(asking, name=f"{caller.core.name}.ask.{to.name}")

    def _complain(self) -> None:
        if self.answered:
            return
        what = f"query {self._message.wire_name!r} to all of {', '.join(self.asked)}"
        if not self.failed:
            raise TimedOutError(what, self._timeout)
        raise ExceptionGroup(f"{what}: nobody answered", list(self.failed.values()))


async def _ask(caller: Caller, message: MultiQuery[Any], to: PresentModule) -> Any:
    kind = type(message)
    payload = encode_message(message)
    answer = await caller.call(kind.wire_name, payload, to=to, timeout=float("inf"), withdraw=True)
    return decode_answer(answer, answer_adapter(kind), kind.wire_name, revision=kind.revision)
