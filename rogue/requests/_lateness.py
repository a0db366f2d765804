"""What is said of deadlines that were accepted and cannot be met any more."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rogue.messages import DeliveryRequest
from rogue.times import show_minute_after, show_time

RELIEF = 0.1
"""Share of the time to a deadline that must be to spare before a warning is taken back."""


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
        f"with what comes first it is expected to be done at {show_minute_after(done)}"
    )
