"""The queue in front of a handler that takes only so many requests at once, as a pure value.

A pool has one queue: a caller that found all modules of a pool busy stands in the line of each of
them under one request id. Whichever has a free place first gives it to the first in its line, and
the caller leaves the other lines. So any free module takes the next request, and a slow one holds
up nobody but those whom it handles.
"""

from __future__ import annotations

import math
from collections import OrderedDict

Request = tuple[str, str]
"""Caller, and message name and request id: an id that is used for two messages is two requests."""

PLACE_LEASE = 1.0
"""Seconds for which a free place is kept for a caller that was told of it."""

MOST_IN_LINE = 1024
"""Requests that may stand in one line."""


def request_of(caller: str, name: str, id: str) -> Request:
    """What tells one request from all others at the module that handles it."""
    return caller, f"{name}/{id}"


class Line:
    """Who is handled, for whom a place is kept, and who waits. Times are of any monotonic clock."""

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        self._handled: set[Request] = set()
        self._kept: dict[Request, float] = {}
        self._waiting: OrderedDict[Request, None] = OrderedDict()

    @property
    def waiting(self) -> int:
        """How many wait."""
        return len(self._waiting)

    @property
    def is_full(self) -> bool:
        """Whether no more may wait."""
        return len(self._waiting) >= MOST_IN_LINE

    def waiting_of(self, caller: str) -> list[Request]:
        """The requests of a caller that wait or have a place kept."""
        return [request for request in (*self._waiting, *self._kept) if request[0] == caller]

    def enter(self, request: Request) -> bool:
        """Begin to handle a request, if a place is kept for it or free."""
        if request not in self._kept and not self._has_room():
            return False
        self._kept.pop(request, None)
        self._waiting.pop(request, None)
        self._handled.add(request)
        return True

    def leave(self, request: Request, now: float) -> list[Request]:
        """A request is done; gives those that have a place now."""
        self._handled.discard(request)
        return self._fill(now)

    def wait(self, request: Request, now: float) -> list[Request]:
        """Stand in line; gives those that have a place now, this one perhaps."""
        if request not in self._kept and request not in self._handled:
            self._waiting[request] = None
        return self._fill(now)

    def withdraw(self, request: Request, now: float) -> list[Request]:
        """A request will not come after all; gives those that have a place now."""
        self._waiting.pop(request, None)
        self._kept.pop(request, None)
        return self._fill(now)

    def expire(self, now: float) -> list[Request]:
        """Give up places whose callers did not come; gives those that have a place now."""
        self._kept = {request: due for request, due in self._kept.items() if due > now}
        return self._fill(now)

    def next_expiry(self) -> float:
        """When `expire` has something to do; infinity for never."""
        return min(self._kept.values(), default=math.inf)

    def _has_room(self) -> bool:
        return len(self._handled) + len(self._kept) < self.capacity

    def _fill(self, now: float) -> list[Request]:
        placed: list[Request] = []
        while self._waiting and self._has_room():
            request, _ = self._waiting.popitem(last=False)
            self._kept[request] = now + PLACE_LEASE
            placed.append(request)
        return placed
