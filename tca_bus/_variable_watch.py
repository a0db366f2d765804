"""Following a shared variable: its value now, and every later one that is still the latest."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Generic, Self, TypeVar

from pydantic import TypeAdapter

from tca_bus._errors import ClosedError, NeverSetError, TcaError
from tca_bus._parts import Parts
from tca_bus._presence import PresenceChange
from tca_bus._rights import Right
from tca_bus._tasks import CENTRAL, OUT_OF_REACH
from tca_bus._topics import Arrival
from tca_bus._variables import GetVariable, Reading, Variable, VariableState
from tca_bus._wire import Payload, decode_answer

logger = logging.getLogger(__name__)

T = TypeVar("T")

ASK_PATIENCE = 60.0
"""Wall seconds of one attempt to read the variable again; repeated while the watch is open."""

RETRY_DELAY = 1.0
"""Wall seconds before the next attempt."""

_STATE: TypeAdapter[VariableState] = TypeAdapter(VariableState)


class VariableWatch(Generic[T]):
    """The values of one variable: an async context manager and an async iterator of `Reading`.

    Begins with the value that the variable has, if it was ever set. The latest wins: a value that
    is replaced before it was taken is not seen, and ``skipped`` counts it. After a restart of the
    router or of central the value is read again, so the latest one is never missed.

    Raises:
        RefusedError: On entering, this module may not read it.
        InvalidMessageError: From the iterator, a value is not of the declared type; the watch
            goes on.
    """

    def __init__(self, parts: Callable[[], Parts], variable: Variable[T]) -> None:
        self.variable = variable
        self.skipped = 0
        self._parts = parts
        self._seen: VariableState | None = None
        self._fresh: VariableState | None = None
        self._bell = asyncio.Event()
        self._reading: asyncio.Task[None] | None = None
        self._ends: list[Callable[[], None]] = []
        self._closed = False

    async def __aenter__(self) -> Self:
        if self._closed or self._ends:
            raise ClosedError(f"watch of {self.variable.name}")
        parts = self._parts()
        parts.core.permissions.check(parts.core.name, Right.READ, self.variable.name)
        key = parts.core.keys.variable(self.variable.name)
        self._ends = [
            parts.topics.listen(key, _decode, self._take),
            parts.core.presence.listen(self._presence_changed),
            parts.on_return(self._read_again),
        ]
        try:
            await parts.core.session.settle(parts.core.keys.all_presence())
        except BaseException:
            self.close()
            raise
        self._read_again()
        return self

    async def __aexit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop watching; a waiting iterator ends."""
        self._closed = True
        self._bell.set()
        if self._reading is not None:
            self._reading.cancel()
        ends, self._ends = self._ends, []
        for end in ends:
            end()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Reading[T]:
        while self._fresh is None:
            if self._closed:
                raise StopAsyncIteration
            self._bell.clear()
            await self._bell.wait()
        state, self._fresh = self._fresh, None
        return reading_of(self.variable, state)

    def _take(self, arrival: Arrival[VariableState]) -> None:
        self._note(arrival.value)

    def _note(self, state: VariableState) -> None:
        if state.name != self.variable.name or not state.is_newer_than(self._seen):
            return
        self._seen = state
        self.skipped += self._fresh is not None
        self._fresh = state
        self._bell.set()

    def _presence_changed(self, change: PresenceChange) -> None:
        if change.module.name == CENTRAL and change.appeared:
            self._read_again()

    def _read_again(self) -> None:
        if self._reading is not None:
            self._reading.cancel()
        parts = self._parts()
        name = f"{parts.core.name}.variable.{self.variable.name}"
        self._reading = parts.core.spawn(self._read(parts), name=name)

    async def _read(self, parts: Parts) -> None:
        question = GetVariable(name=self.variable.name)
        while True:
            try:
                self._note(await parts.sender.ask_central(question, timeout=ASK_PATIENCE))
            except NeverSetError:
                return
            except OUT_OF_REACH:
                await asyncio.sleep(RETRY_DELAY)
            except TcaError as error:
                logger.warning("variable %s cannot be read: %s", self.variable.name, error)
                return
            else:
                return


def reading_of(variable: Variable[T], state: VariableState) -> Reading[T]:
    """A state with its value as the variable's type.

    Raises:
        InvalidMessageError: The value is of another.
    """
    value = variable.decode(state.value)
    return Reading(value, state.sequence, state.writer, state.changed)


def _decode(payload: Payload) -> tuple[VariableState]:
    return (decode_answer(payload, _STATE, "tca.variable"),)
