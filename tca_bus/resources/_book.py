"""Who holds what, and who waits: the state that the rules for turns and rings look at."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import Counter
from dataclasses import dataclass, field

from tca_bus.resources._hold import HANDLERS, Hold, Order
from tca_bus.resources._tasks import Tasks

Index = dict[str, dict[str, Hold]]


@dataclass(slots=True)
class Thing:
    """A thing in the world."""

    capacity: int = 1
    pending: int | None = None


@dataclass
class Book:
    """All holds that have not ended, by id, by resource, by task and by the hold around them."""

    tasks: Tasks
    holds: dict[str, Hold] = field(default_factory=dict)
    things: dict[str, Thing] = field(default_factory=dict)
    dropped: Counter[str] = field(default_factory=Counter)
    _queues: dict[str, list[tuple[Order, str]]] = field(default_factory=dict)
    _leases: Index = field(default_factory=dict)
    _keepers: dict[str, Hold] = field(default_factory=dict)
    _shutting: dict[str, Hold] = field(default_factory=dict)
    _of_task: Index = field(default_factory=dict)
    _inside: Index = field(default_factory=dict)

    def add(self, hold: Hold) -> None:
        """Enter a hold that waits."""
        self.holds[hold.id] = hold
        for name in hold.names:
            insort(self._queues.setdefault(name, []), (hold.order, hold.id))
        if not hold.is_lease and HANDLERS in hold.names[0]:
            self._shutting[hold.id] = hold
        for outer in hold.request.holding:
            self._inside.setdefault(outer, {})[hold.id] = hold
        if hold.request.task is not None:
            self._of_task.setdefault(hold.request.task, {})[hold.id] = hold

    def grant(self, hold: Hold, time: float) -> None:
        """Let a hold begin."""
        self._wait_no_more(hold)
        hold.granted = time
        for name in hold.names:
            if hold.is_lease:
                self._leases.setdefault(name, {})[hold.id] = hold
            else:
                self._keepers[name] = hold

    def remove(self, hold: Hold) -> None:
        """Take a hold out."""
        self.holds.pop(hold.id, None)
        self._wait_no_more(hold)
        for name in hold.names:
            _discard(self._leases, name, hold.id)
            if self._keepers.get(name) is hold:
                del self._keepers[name]
        if hold.request.task is not None:
            _discard(self._of_task, hold.request.task, hold.id)

    def capacity(self, name: str) -> int:
        """How many places a thing has."""
        thing = self.things.get(name)
        return thing.capacity if thing is not None else 1

    def limit(self, name: str) -> int | None:
        """How many may wait for a thing."""
        thing = self.things.get(name)
        return thing.pending if thing is not None else None

    def free(self, name: str) -> int:
        """How many places of a thing nobody has."""
        return self.capacity(name) - len(self._leases.get(name, ()))

    def names(self) -> list[str]:
        """All resources that are declared or in use."""
        return sorted({*self.things, *self._queues, *self._leases, *self._keepers})

    def shutting(self) -> list[str]:
        """The handlers' resources that a lock or reservation waits for."""
        return [hold.names[0] for hold in self._shutting.values()]

    def is_shutting(self, name: str) -> bool:
        """Whether a lock or reservation is the next to have a resource."""
        first = self.foremost(name, 1)
        return name not in self._keepers and bool(first) and not first[0].is_lease

    def waiting(self, name: str) -> list[Hold]:
        """All that wait for a resource, the next one first."""
        return [self.holds[id] for _, id in self._queues.get(name, ())]

    def foremost(self, name: str, most: int) -> list[Hold]:
        """The first that wait for a resource."""
        return [self.holds[id] for _, id in self._queues.get(name, ())[:most]]

    def all_waiting(self) -> list[Hold]:
        """All that wait for anything."""
        return [hold for hold in self.holds.values() if hold.granted is None]

    def at(self, name: str) -> list[Hold]:
        """All that hold a resource, then all that wait for it."""
        keeper = self._keepers.get(name)
        return [*([keeper] if keeper else []), *self.leases(name), *self.waiting(name)]

    def leases(self, name: str) -> list[Hold]:
        """Those that have a place of a thing."""
        return list(self._leases.get(name, {}).values())

    def keeper(self, name: str) -> Hold | None:
        """The lock or reservation under which a resource is."""
        return self._keepers.get(name)

    def bars(self, name: str, hold: Hold) -> Hold | None:
        """The lock or reservation of a resource that does not let a hold pass."""
        keeper = self._keepers.get(name)
        if keeper is None or (hold.is_lease and hold.module == keeper.passes):
            return None
        return keeper

    def before(self, name: str, hold: Hold) -> list[Hold]:
        """Those that wait for a resource, may have it, and come before a hold."""
        ahead = self.foremost(name, self._position(name, hold))
        return [other for other in ahead if not self.bars(name, other)]

    def claims(self, name: str, hold: Hold) -> int:
        """How many places of a thing those before a hold keep from it."""
        if name in self._keepers:
            return len(self.before(name, hold))
        return self._position(name, hold)

    def of_task(self, task: str) -> list[Hold]:
        """The holds that end with a task."""
        return list(self._of_task.get(task, {}).values())

    def inside(self, hold: Hold) -> list[Hold]:
        """The holds that are waited for by whoever has this one, and keeps it meanwhile."""
        return list(self._inside.get(hold.id, {}).values())

    def inner(self) -> list[Hold]:
        """All that are waited for inside another one, the next one first."""
        found = {id: hold for holds in self._inside.values() for id, hold in holds.items()}
        return sorted(found.values(), key=lambda hold: hold.order)

    def in_the_way(self, hold: Hold) -> list[tuple[str, str]]:
        """What has to go before a lock or reservation can begin: ("hold" or "task", id)."""
        name = hold.names[0]
        if HANDLERS in name:
            return [("task", t) for t in self.tasks.attending(name) if t != hold.request.task]
        return [("hold", h.id) for h in self.leases(name) if h.module != hold.module]

    def _position(self, name: str, hold: Hold) -> int:
        return bisect_left(self._queues.get(name, []), (hold.order, hold.id))

    def _wait_no_more(self, hold: Hold) -> None:
        self._shutting.pop(hold.id, None)
        for outer in hold.request.holding:
            _discard(self._inside, outer, hold.id)
        if hold.granted is not None:
            return
        for name in hold.names:
            queue = self._queues[name]
            del queue[self._position(name, hold)]
            if not queue:
                del self._queues[name]


def _discard(index: Index, key: str, id: str) -> None:
    holds = index.get(key, {})
    holds.pop(id, None)
    if not holds:
        index.pop(key, None)
