"""The holds on resources: one event in, what is to be recorded and told out."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from tca_bus._errors import DeadlockError, RefusedError, ring_words
from tca_bus._failure import Failure
from tca_bus._resource_messages import AcquireResources, HoldStatus
from tca_bus.resources._book import Book, Thing
from tca_bus.resources._events import Asked, Declared, Finished, Granted, ResourceEvent
from tca_bus.resources._hold import HANDLERS, Hold
from tca_bus.resources._rings import ring_behind, rings
from tca_bus.resources._tasks import NoTasks, Tasks
from tca_bus.resources._turns import next_turn, surplus
from tca_bus.resources._waits import Member
from tca_bus.resources._words import member_words, waiting_words
from tca_bus.tasktree import Gate

MOST_ENDED = 1000
"""Ended holds whose last status is kept, for those who ask late."""

GENERATION_STEP = 10**12
"""Sequence numbers begin here times the generation, so that a restart never goes back."""


@dataclass(slots=True)
class Changes:
    """What follows from an event: write ``records``, then tell ``statuses``.

    ``gates`` are the handlers' resources that are held by somebody else now; None is free.
    """

    records: list[ResourceEvent] = field(default_factory=list)
    statuses: list[HoldStatus] = field(default_factory=list)
    gates: dict[str, Gate | None] = field(default_factory=dict)


class Ledger:
    """All holds that have not ended.

    Pure: each method is one event; it runs until nothing more can be granted and gives what
    changed. The records, replayed in order on a fresh ledger, give the same one.

    Args:
        tasks: A look into the task tree, for handlers' resources and for rings.
        generation: How often this ledger was rebuilt from its records.
    """

    def __init__(self, tasks: Tasks | None = None, *, generation: int = 0) -> None:
        self.book = Book(tasks or NoTasks())
        self._ended: OrderedDict[str, HoldStatus] = OrderedDict()
        self._gates: dict[str, Gate | None] = {}
        self._sequence = generation * GENERATION_STEP
        self._serial = 0
        self._touched: set[str] = set()

    def declare(self, time: float, name: str, capacity: int, pending: int | None) -> Changes:
        """Say how many places a thing has; those that hold more keep them."""
        changes = Changes()
        if self.book.things.get(name) != Thing(capacity, pending):
            self._happen(Declared(time, name, capacity, pending), changes)
        return self._settle(time, changes)

    def ask(self, time: float, module: str, request: AcquireResources) -> Changes:
        """Hold resources as soon as it is this one's turn; what is known changes nothing.

        Raises:
            RefusedError: The id is that of another hold, the module has a lock or reservation of
                the resource already, or the names cannot be held so.
            DeadlockError: It would wait for itself.
        """
        known = self.book.holds.get(request.id)
        if known is not None or request.id in self._ended:
            if known is not None and (known.module != module or known.names != request.names):
                raise RefusedError(f"hold {request.id}", "another hold has this id")
            return Changes()
        self._check(module, request)
        changes = Changes()
        self._happen(Asked(time, module, request), changes)
        hold = self.book.holds[request.id]
        ring = ring_behind(self.book, ("hold", hold.id))
        if ring is not None:
            members = [member_words(self.book, member) for member in ring]
            self.book.remove(hold)
            self._touched.clear()
            raise DeadlockError(", ".join(request.names), members)
        return self._settle(time, changes)

    def finish(self, time: float, id: str, failure: Failure | None = None) -> Changes:
        """End a hold, or the wait for it; one that is not known will not begin any more."""
        changes = Changes()
        if id in self.book.holds:
            self._happen(Finished(time, id, failure), changes)
        return self._settle(time, changes)

    def forget(self, time: float, id: str, module: str) -> None:
        """A release came before what it releases: when that comes it has ended already."""
        if id not in self.book.holds and id not in self._ended:
            request = AcquireResources(id=id, names=("unknown",))
            gone = Hold(request, module, time, 0, self._next(), ended=time)
            self._keep(gone.status(None))

    def holder_gone(self, time: float, incarnation: str) -> Changes:
        """A module is gone: its holds end. Those that it took for a task end with the task."""
        failure = Failure(name="holder_lost", text="its holder was lost")
        gone = [
            hold
            for hold in self.book.holds.values()
            if hold.request.incarnation == incarnation
            and (hold.request.task is None or hold.granted is None)
        ]
        return self._finish_all(time, gone, failure)

    def task_moved(self, time: float, task: str, attempt: int | None) -> Changes:
        """A task is at this try now, or (None) has ended: the holds of other tries end."""
        gone = [hold for hold in self.book.of_task(task) if hold.request.attempt != attempt]
        text = "its task ended" if attempt is None else "its task is handled again"
        return self._finish_all(time, gone, Failure(name="task_ended", text=text))

    def unlock(self, time: float, name: str, by: str) -> Changes:
        """End the lock or reservation of a resource, or else all its leases."""
        keeper = self.book.keeper(name)
        freed = [keeper] if keeper is not None else self.book.leases(name)
        failure = Failure(name="unlocked", text=f"unlocked by {by}", data={"resource": name})
        return self._finish_all(time, freed, failure)

    def settle(self, time: float) -> Changes:
        """Something changed in the task tree."""
        self._touched.update(self.book.shutting())
        return self._settle(time, Changes())

    def replay(self, events: Iterable[ResourceEvent]) -> None:
        """Apply recorded events; `settle` gives what follows once the task tree is there too."""
        for event in events:
            self._happen(event, Changes())

    def status(self, id: str) -> HoldStatus | None:
        """The status of a hold that has not ended, or ended not long ago."""
        hold = self.book.holds.get(id)
        return self._status(hold) if hold is not None else self._ended.get(id)

    def ring_behind(self, member: Member) -> list[Member] | None:
        """The ring in which a hold or task waits for itself, or that it waits for."""
        return ring_behind(self.book, member)

    def rings(self, tasks: Iterable[str]) -> list[list[Member]]:
        """All rings behind what waits, and behind these tasks."""
        return rings(self.book, tasks)

    def words(self, ring: Iterable[Member]) -> str:
        """A ring as a sentence."""
        return ring_words([member_words(self.book, member) for member in ring])

    def _check(self, module: str, request: AcquireResources) -> None:
        what = f"a {request.kind} of {', '.join(request.names)}"
        if len(set(request.names)) != len(request.names):
            raise RefusedError(what, "it names a resource twice")
        if request.kind == "lease":
            handlers = [name for name in request.names if HANDLERS in name]
            if handlers:
                why = f"{handlers[0]} is for its messages; reserve or lock it instead"
                raise RefusedError(what, why)
            return
        if len(request.names) > 1:
            raise RefusedError(what, "a lock or reservation is of one resource")
        before = (h for h in self.book.at(request.names[0]) if not h.is_lease)
        own = next((h for h in before if h.module == module), None)
        if own is not None:
            raise RefusedError(what, f"{own.words()} of it already ({own.id})")

    def _finish_all(self, time: float, holds: Sequence[Hold], failure: Failure) -> Changes:
        changes = Changes()
        for hold in list(holds):
            self._happen(Finished(time, hold.id, failure), changes)
        return self._settle(time, changes)

    def _happen(self, event: ResourceEvent, changes: Changes) -> None:
        changes.records.append(event)
        match event:
            case Declared():
                self.book.things[event.name] = Thing(event.capacity, event.pending)
                self._touched.add(event.name)
                return
            case Asked():
                self._serial += 1
                hold = Hold(event.request, event.module, event.time, self._serial, 0)
                self.book.add(hold)
            case Granted():
                hold = self.book.holds[event.id]
                self.book.grant(hold, event.time)
            case Finished():
                hold = self.book.holds[event.id]
                self.book.remove(hold)
                hold.ended, hold.failure = event.time, event.failure
        self._touched.update(hold.names)
        hold.sequence = self._next()
        if hold.ended is not None:
            self._keep(hold.status(None))
        changes.statuses.append(self._status(hold))

    def _settle(self, time: float, changes: Changes) -> Changes:
        """Grant what can be granted, drop what is too much, and see who holds what now."""
        while self._grant(time, changes) or self._drop(time, changes):
            pass
        for name in self._touched:
            self._compare_gate(name, changes)
        self._touched.clear()
        return changes

    def _grant(self, time: float, changes: Changes) -> bool:
        hold = next_turn(self.book, self._touched)
        if hold is not None:
            self._happen(Granted(time, hold.id), changes)
        return hold is not None

    def _drop(self, time: float, changes: Changes) -> bool:
        """Drop one of too many that wait; what it claimed may be another's turn."""
        for name in self._touched:
            hold = surplus(self.book, name)
            if hold is not None:
                self.book.dropped[name] += 1
                self._happen(Finished(time, hold.id, self._too_many(name)), changes)
                return True
        return False

    def _too_many(self, name: str) -> Failure:
        limit = self.book.limit(name)
        text = f"more than {limit} waited for {name!r}; the oldest was dropped"
        return Failure(name="pending_limit", text=text, data={"resource": name, "limit": limit})

    def _compare_gate(self, name: str, changes: Changes) -> None:
        """See who holds a handlers' resource, or is the first to wait for it."""
        if HANDLERS not in name:
            return
        hold = next(iter(self.book.at(name)), None)
        only = hold.passes if hold is not None and hold.granted is not None else None
        gate = Gate(hold.id, only, hold.words()) if hold is not None else None
        if gate != self._gates.get(name):
            changes.gates[name] = gate
            self._gates[name] = gate

    def _status(self, hold: Hold) -> HoldStatus:
        waits = hold.granted is None and hold.ended is None
        return hold.status(waiting_words(self.book, hold) if waits else None)

    def _keep(self, status: HoldStatus) -> None:
        self._ended[status.id] = status
        while len(self._ended) > MOST_ENDED:
            self._ended.popitem(last=False)

    def _next(self) -> int:
        self._sequence += 1
        return self._sequence
