"""Interrupts: conditions that are signalled, and handlers that are polled once a cycle.

Source: PRODIGY4.0's ``define-handler`` and ``signal``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from rogue.prodigy._errors import FunctionError, UnknownNameError
from rogue.prodigy._result import Stop

ALWAYS = "always"
"""The condition of handlers that run every cycle."""
START_RUN = "start-run"
"""Signalled by the search before its first cycle."""
ACHIEVE = "achieve"
"""Signalled by the search when *finish* is applicable, before it ends."""
CONDITIONS = (ALWAYS, START_RUN, ACHIEVE)

MOST_SIGNALS = 10_000
"""Signals that may wait for the next poll."""

BoundHandler = Callable[[object], object]


class Handlers:
    """The handlers of one search, and the signals that wait for the next poll."""

    def __init__(self) -> None:
        self._handlers: dict[str, list[BoundHandler]] = {name: [] for name in CONDITIONS}
        self._signals: deque[tuple[str, object]] = deque()

    def define(self, condition: str, handler: BoundHandler) -> None:
        """Add a handler; those of a condition run in the order of their definition."""
        self._handlers.setdefault(condition, []).append(handler)

    def has(self, condition: str) -> bool:
        """Say whether a condition has handlers."""
        return bool(self._handlers.get(condition))

    def signal(self, condition: str, data: object = None) -> None:
        """Let the handlers of ``condition`` run at the next poll.

        Raises:
            UnknownNameError: If no handler was ever defined for it.
            OverflowError: If too many signals wait already.
        """
        if condition not in self._handlers:
            raise UnknownNameError("condition", condition, self._handlers)
        if len(self._signals) >= MOST_SIGNALS:
            raise OverflowError(f"{MOST_SIGNALS} signals wait for a poll already")
        if self._handlers[condition]:
            self._signals.append((condition, data))

    def poll(self) -> Stop | None:
        """Run the "always" handlers, then those of what was signalled, until one says stop.

        Signals that handlers give wait for the next poll. Signals behind a stop are dropped.

        Raises:
            FunctionError: If a handler raises or returns anything but None or Stop.
        """
        waiting, self._signals = self._signals, deque()
        for condition, data in [(ALWAYS, None), *waiting]:
            for handler in tuple(self._handlers[condition]):
                stop = _called(condition, handler, data)
                if stop is not None:
                    return stop
        return None


def _called(condition: str, handler: BoundHandler, data: object) -> Stop | None:
    try:
        answer = handler(data)
    except Exception as error:
        raise FunctionError(f"handler of {condition}", (data,), f"raised {error!r}") from error
    if answer is None or isinstance(answer, Stop):
        return answer
    raise FunctionError(f"handler of {condition}", (data,), f"gave {answer!r}, expected a Stop")
