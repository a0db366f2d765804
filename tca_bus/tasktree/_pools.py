"""Who can handle what, and which nodes wait for them: one queue per message name."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field


@dataclass(slots=True)
class Provider:
    """One incarnation of a module: how many of which message it takes, and which it has."""

    module: str
    incarnation: str
    capacities: Mapping[str, int]
    present: bool = True
    working: dict[str, dict[str, None]] = field(default_factory=dict)

    def load(self, name: str) -> int:
        """How many nodes of the message it has."""
        return len(self.working.get(name, ()))

    def is_free(self, name: str) -> bool:
        """Whether it takes one more of the message now."""
        return self.present and self.load(name) < self.capacities.get(name, 0)


@dataclass(frozen=True, slots=True)
class Assignment:
    """A node and the provider chosen for it."""

    id: str
    module: str
    incarnation: str


Priority = tuple[int, int]
"""Of the whole task, and of the message among those of the same task; higher goes first."""

Key = tuple[int, int, int]
"""Sorts what waits: both priorities, then the order of arrival."""

Queue = tuple[str, str | None]
"""A message name, and the module that must have it, if it cannot be another."""


@dataclass(slots=True)
class _Wait:
    queue: Queue
    key: Key


class Pools:
    """The providers of each message, and the nodes that are ready for one.

    Of several providers the one with the fewest nodes of the message gets the next; of several
    waiting nodes the one with the highest priority goes first, else the one that came first.
    """

    def __init__(self) -> None:
        self._providers: dict[str, Provider] = {}
        self._queues: dict[Queue, list[tuple[Key, str]]] = {}
        self._waiting: dict[str, _Wait] = {}
        self._missing: dict[str, int] = {}
        self._serial = 0

    def appear(self, module: str, incarnation: str, capacities: Mapping[str, int]) -> None:
        """Add a provider, or change what is known of it."""
        known = self._providers.get(incarnation)
        provider = known or Provider(module, incarnation, capacities)
        provider.capacities, provider.present = dict(capacities), True
        self._providers[incarnation] = provider
        for id in [id for id in self._missing if self._has_provider(self._waiting[id].queue)]:
            del self._missing[id]

    def lose(self, incarnation: str) -> tuple[str, list[str]]:
        """Remove a provider; gives its module's name and the nodes that it had."""
        provider = self._providers.pop(incarnation, None)
        if provider is None:
            return "", []
        return provider.module, [id for ids in provider.working.values() for id in ids]

    def names(self) -> set[str]:
        """The messages that somebody handles."""
        present = (p for p in self._providers.values() if p.present)
        return {name for provider in present for name in provider.capacities}

    def provides(self, name: str) -> list[Provider]:
        """The present providers of a message."""
        return [p for p in self._providers.values() if p.present and name in p.capacities]

    def incarnations(self) -> dict[str, str]:
        """The incarnations that have nodes or are present, with the names of their modules."""
        return {p.incarnation: p.module for p in self._providers.values()}

    def wait(self, id: str, name: str, priority: Priority, *, only: str | None = None) -> None:
        """Queue a node that is ready for its handler, perhaps for one in module ``only``."""
        self._serial += 1
        key = (-priority[0], -priority[1], self._serial)
        self._waiting[id] = _Wait((name, only), key)
        heapq.heappush(self._queues.setdefault((name, only), []), (key, id))

    def forget(self, id: str) -> None:
        """Take a node out of the queues."""
        self._waiting.pop(id, None)
        self._missing.pop(id, None)

    def occupy(self, id: str, name: str, module: str, incarnation: str) -> None:
        """Count a node on the provider that has it now."""
        self.forget(id)
        provider = self._providers.get(incarnation)
        if provider is None:
            provider = Provider(module, incarnation, {}, present=False)
            self._providers[incarnation] = provider
        provider.working.setdefault(name, {})[id] = None

    def release(self, id: str, name: str, incarnation: str) -> None:
        """Give back the place of a node whose handler has ended."""
        provider = self._providers.get(incarnation)
        if provider is None:
            return
        provider.working.get(name, {}).pop(id, None)
        if not provider.present and not any(provider.working.values()):
            del self._providers[incarnation]

    def assign(self) -> Assignment | None:
        """Choose the next node that can be handled now, and its provider."""
        for queue in list(self._queues):
            head = self._head(queue)
            if head is None:
                del self._queues[queue]
                continue
            name, only = queue
            free = [p for p in self.provides(name) if p.is_free(name) and only in {None, p.module}]
            if free:
                chosen = min(free, key=lambda provider: provider.load(name))
                return Assignment(head, chosen.module, chosen.incarnation)
        return None

    def newly_missing(self) -> Iterator[tuple[str, int]]:
        """Waiting nodes for which nobody is there and that were not told of before."""
        for id, wait in self._waiting.items():
            if id not in self._missing and not self._has_provider(wait.queue):
                self._serial += 1
                self._missing[id] = self._serial
                yield id, self._serial

    def forget_missing(self) -> None:
        """Tell of all waiting nodes again."""
        self._missing.clear()

    def is_missing(self, id: str, number: int) -> bool:
        """Whether that wait of the node still lasts."""
        return self._missing.get(id) == number

    def _has_provider(self, queue: Queue) -> bool:
        name, only = queue
        return any(only in {None, provider.module} for provider in self.provides(name))

    def _head(self, queue: Queue) -> str | None:
        waiting = self._queues[queue]
        while waiting:
            key, id = waiting[0]
            wait = self._waiting.get(id)
            if wait is not None and wait.key == key:
                return id
            heapq.heappop(waiting)
        return None
