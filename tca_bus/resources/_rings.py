"""What each hold waits for, and the rings in that."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from tca_bus.resources._book import Book
from tca_bus.resources._hold import Hold
from tca_bus.resources._waits import Clause, Member, find_ring


def ring_behind(book: Book, start: Member, *, with_claims: bool = False) -> list[Member] | None:
    """The ring in which a hold or task waits for itself, or that it waits for.

    ``with_claims`` counts also those who only come before a hold, besides those who hold.
    """

    def clauses(member: Member) -> Sequence[Clause]:
        kind, id = member
        if kind == "task":
            return _of_task(book, id)
        hold = book.holds.get(id)
        if hold is None:
            return ()
        if hold.granted is not None:
            return _of_holder(book, hold)
        return list(_of_waiter(book, hold, with_claims=with_claims))

    return find_ring(start, clauses)


def rings(book: Book, tasks: Iterable[str]) -> list[list[Member]]:
    """All rings behind the holds that wait and these tasks, each once."""
    found: dict[frozenset[Member], list[Member]] = {}
    starts: list[Member] = [("hold", hold.id) for hold in book.all_waiting()]
    for start in [*starts, *(("task", task) for task in tasks)]:
        ring = ring_behind(book, start)
        if ring is not None:
            found.setdefault(frozenset(ring), ring)
    return list(found.values())


def _of_task(book: Book, task: str) -> Sequence[Clause]:
    """A handler moves when anything that it waits for does: it may not need all of it."""
    asked: set[Member] = {("hold", h.id) for h in book.of_task(task) if h.granted is None}
    asked |= {("task", other) for other in book.tasks.awaited(task)}
    return [Clause(1, frozenset(asked))] if asked else book.tasks.clauses(task)


def _of_holder(book: Book, hold: Hold) -> Sequence[Clause]:
    """A holder moves unless it is known to wait while it keeps the hold."""
    inner: set[Member] = {("hold", inner.id) for inner in book.inside(hold)}
    inner |= {("task", task) for task in book.tasks.awaited_with(hold.id)}
    task = hold.request.task
    if not inner and task is not None and book.tasks.is_handled(task):
        inner = {("task", task)}
    return [Clause(1, frozenset(inner))] if inner else ()


def _of_waiter(book: Book, hold: Hold, *, with_claims: bool) -> Iterable[Clause]:
    for name in hold.names:
        keeper = book.bars(name, hold)
        before = book.before(name, hold) if with_claims else []
        if keeper is not None:
            yield _all_of([keeper.id])
        yield from (_all_of([other.id]) for other in before if not other.is_lease)
        if hold.is_lease:
            yield from _places(book, name, [h.id for h in before if h.is_lease])
        else:
            for kind, id in book.in_the_way(hold):
                yield Clause(1, frozenset({("task", id)})) if kind == "task" else _all_of([id])


def _places(book: Book, name: str, ahead: list[str]) -> Iterable[Clause]:
    taken = [lease.id for lease in book.leases(name)]
    needs = len(taken) + len(ahead) - book.capacity(name) + 1
    if needs > 0:
        yield Clause(needs, frozenset(("hold", id) for id in [*taken, *ahead]))


def _all_of(holds: list[str]) -> Clause:
    return Clause(len(holds), frozenset(("hold", id) for id in holds))
