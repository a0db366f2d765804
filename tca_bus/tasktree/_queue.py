"""The nodes that wait for the handler of one message."""

from __future__ import annotations

import heapq
from collections.abc import Iterator

Rank = tuple[float, ...]
"""Minus the priority: the lowest goes first."""

Key = tuple[Rank, int]
"""Rank and time of arrival, as a serial number."""

Priority = float | tuple[float, ...]
"""The highest goes first; tuples, all of one length, compare from the left."""


def rank_of(priority: Priority) -> Rank:
    """Turn a priority round, so that the highest comes first."""
    parts = priority if isinstance(priority, tuple) else (priority,)
    return tuple(-part for part in parts)


class Queue:
    """Highest priority first, and first come first within one."""

    def __init__(self) -> None:
        self._keys: dict[str, Key] = {}
        self._heap: list[tuple[Key, str]] = []

    def __len__(self) -> int:
        return len(self._keys)

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._keys, key=self._keys.__getitem__))

    def put(self, id: str, key: Key) -> None:
        """Add a node, or move it to another place."""
        self._keys[id] = key
        heapq.heappush(self._heap, (key, id))

    def discard(self, id: str) -> None:
        """Take a node out."""
        self._keys.pop(id, None)

    def key(self, id: str) -> Key:
        """The place of a node."""
        return self._keys[id]

    def head(self) -> str | None:
        """The node that is next."""
        while self._heap:
            key, id = self._heap[0]
            if self._keys.get(id) == key:
                return id
            heapq.heappop(self._heap)
        return None

    def victim(self) -> str:
        """Of the lowest priority the node that came first: the one that a limit drops."""
        lowest = max(rank for rank, _ in self._keys.values())
        return min(
            (id for id, (rank, _) in self._keys.items() if rank == lowest),
            key=self._keys.__getitem__,
        )

    def drop(self, id: str) -> None:
        """Take a node out and let those of its priority move up to the places before theirs.

        So the newest takes the last place that the message had, and its turn among other
        messages is kept (``tcaLimitPendingMessages``).
        """
        place = self._keys.pop(id)
        later = sorted((key, other) for other, key in self._keys.items() if key > place)
        for key, other in later:
            if key[0] != place[0]:
                break
            self.put(other, place)
            place = key
