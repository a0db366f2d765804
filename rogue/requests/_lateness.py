"""What is said of deadlines that cannot be met: at once, and of those accepted earlier."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from rogue.errors import RequestError
from rogue.messages import DeliveryRequest, Objection, Refusal
from rogue.times import show_deadline, show_time

RELIEF = 0.1
"""Share of the time to a deadline that must be to spare before a warning is taken back."""


class TooLateError(RequestError):
    """A deadline that cannot be met; ``earliest`` is when the errand can be done.

    ``alone`` is when it could be done if there were nothing else to do.
    """

    exit_code = 7

    def __init__(self, deadline: float, *, earliest: float, alone: float) -> None:
        self.deadline, self.earliest, self.alone = deadline, earliest, alone
        busy = alone <= deadline
        why = "what was accepted before comes first" if busy else "the way alone takes that long"
        when = f"{_minute(earliest)} is the earliest"
        expected = f"a later deadline, or --anyway to have it tried; {when}"
        super().__init__(
            Refusal.TOO_LATE,
            f"deadline {show_time(deadline)} cannot be met: {why}, {when}; "
            "name a later one, or --anyway to have it tried",
            Objection(
                field="deadline",
                value=show_deadline(deadline),
                expected=expected,
                earliest=earliest,
            ),
        )


def warnings(
    requests: Iterable[DeliveryRequest], expected: Mapping[str, float], now: float
) -> Iterator[tuple[DeliveryRequest, str | None]]:
    """Requests of which something else is to be feared than was said, and what; None: nothing.

    Args:
        requests: those that are open.
        expected: when they will be done, by their ids, in seconds since the epoch.
        now: the time.
    """
    for request in requests:
        done = expected.get(request.id)
        if done is None or request.closing is not None:
            continue
        if done > request.deadline and request.warning is None:
            yield request, _warning(request, done)
        elif request.warning and done + RELIEF * (request.deadline - now) <= request.deadline:
            yield request, None


def _warning(request: DeliveryRequest, done: float) -> str:
    return (
        f"its deadline, {show_time(request.deadline)}, cannot be met any more: "
        f"with what comes first it is expected to be done at {_minute(done)}"
    )


def _minute(when: float) -> str:
    """The full minute in which something will be over."""
    return show_time(math.ceil(when / 60.0) * 60.0)
