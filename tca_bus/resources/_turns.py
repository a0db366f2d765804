"""Whose turn it is.

Holds are granted in their order. One that waits claims a place of each thing that it wants, so
that none behind it takes a place that it needs; those that want other things pass. One that a
lock or reservation bars claims nothing behind it. So a hold of several things is never overtaken
at any of them by later ones of its priority, and begins when those before it have ended. All
places of a hold are taken at once: who waits has nothing for it.

A hold that is asked for *inside* another one may find its place free but claimed by one that, in
the end, waits for the outer hold. Then it is granted out of turn, since nobody would ever move.
"""

from __future__ import annotations

from collections.abc import Iterable

from tca_bus.resources._book import Book
from tca_bus.resources._hold import Hold
from tca_bus.resources._rings import ring_behind


def next_turn(book: Book, names: Iterable[str]) -> Hold | None:
    """The next hold that may begin now, of those that wait for these resources.

    Only the first few of each can: as many as there are places, or a lock or reservation.
    """
    found: Hold | None = None
    for name in names:
        for hold in _candidates(book, name):
            if (found is None or hold.order < found.order) and _is_next(book, hold):
                found = hold
    return found or _out_of_turn(book)


def surplus(book: Book, name: str) -> Hold | None:
    """Of more waiting leases than may wait for a thing the oldest of the lowest priority."""
    limit = book.limit(name)
    if limit is None:
        return None
    waiting = [hold for hold in book.waiting(name) if hold.is_lease]
    if len(waiting) <= limit:
        return None
    lowest = min(hold.request.priority for hold in waiting)
    return next(hold for hold in waiting if hold.request.priority == lowest)


def _candidates(book: Book, name: str) -> list[Hold]:
    if book.keeper(name) is not None:
        return book.waiting(name)
    return book.foremost(name, max(book.free(name), 1))


def _is_next(book: Book, hold: Hold) -> bool:
    """Whether there is a place for it beside those that hold, and those that come before."""
    if not _fits(book, hold):
        return False
    if not hold.is_lease:
        return not book.before(hold.names[0], hold)
    if any(book.is_shutting(name) for name in hold.names):
        return False
    return all(book.claims(name, hold) < book.free(name) for name in hold.names)


def _fits(book: Book, hold: Hold) -> bool:
    """Whether there is a place for it beside those that hold."""
    if any(book.bars(name, hold) for name in hold.names):
        return False
    if not hold.is_lease:
        return not book.in_the_way(hold)
    return all(book.free(name) > 0 for name in hold.names)


def _out_of_turn(book: Book) -> Hold | None:
    ready = (hold for hold in book.inner() if _fits(book, hold))
    stuck = (h for h in ready if ring_behind(book, ("hold", h.id), with_claims=True))
    return next(stuck, None)
