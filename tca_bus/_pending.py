"""The queries under way from one module, as a table: who is asked, and what is due when.

Times are seconds of any monotonic clock.
"""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass, field

from tca_bus._bridge import Answer
from tca_bus._presence import PresentModule
from tca_bus._wire import Payload

PATIENCE = 1.0
"""Seconds without an answer after which a published query is asked as a Zenoh query too."""


@dataclass(slots=True, eq=False)
class Call:
    """One query under way; ``due`` is when it is looked at again, at the latest its deadline."""

    id: str
    name: str
    callee: PresentModule
    payload: Payload
    attachment: bytes
    deadline: float
    answer: asyncio.Future[Answer]
    due: float = math.inf
    asking: asyncio.Task[None] | None = None

    def settle(self, answer: Answer) -> None:
        """Give the answer; the first one counts."""
        if not self.answer.done():
            self.answer.set_result(answer)

    def fail(self, error: Exception) -> None:
        """End without an answer."""
        if not self.answer.done():
            self.answer.set_exception(error)


@dataclass(slots=True)
class PendingCalls:
    """The calls that wait for an answer, by request id."""

    _calls: dict[str, Call] = field(default_factory=dict)

    def add(self, call: Call, now: float) -> None:
        """Begin to wait: until the deadline, or until patience ends before it."""
        call.due = min(call.deadline, now + PATIENCE)
        self._calls[call.id] = call

    def remove(self, call: Call) -> None:
        """Wait no longer."""
        self._calls.pop(call.id, None)

    def find(self, id: str, callee: str) -> Call | None:
        """The call that an answer is for, if it comes from the module that was asked."""
        call = self._calls.get(id)
        return call if call is not None and call.callee.name == callee else None

    def all(self) -> list[Call]:
        """All calls under way."""
        return list(self._calls.values())

    def to(self, incarnation: str) -> list[Call]:
        """The calls to one incarnation of a module."""
        return [call for call in self._calls.values() if call.callee.incarnation == incarnation]

    def take_due(self, now: float) -> list[Call]:
        """The calls that are due; each is due again at its deadline."""
        found = [call for call in self._calls.values() if call.due <= now]
        for call in found:
            call.due = call.deadline
        return found

    def next_due(self) -> float:
        """When the next call is due; infinity for never."""
        return min((call.due for call in self._calls.values()), default=math.inf)

    def __len__(self) -> int:
        return len(self._calls)
