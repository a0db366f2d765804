"""Holds and what they wait for, in words."""

from __future__ import annotations

from tca_bus.resources._book import Book
from tca_bus.resources._hold import Hold
from tca_bus.resources._waits import Member

MOST_NAMED = 3
"""How many things one text names."""


def waiting_words(book: Book, hold: Hold) -> str:
    """What a hold waits for: who has its resources, or comes before it."""
    found: dict[str, None] = {}
    for name in hold.names:
        found.update(dict.fromkeys(f"{name}, {words}" for words in _before(book, hold, name)))
    texts = list(found)
    more = f" and {len(texts) - MOST_NAMED} more" if len(texts) > MOST_NAMED else ""
    return "; ".join(texts[:MOST_NAMED]) + more


def _before(book: Book, hold: Hold, name: str) -> list[str]:
    keeper = book.bars(name, hold)
    if keeper is not None:
        return [f"of which {keeper.words()}"]
    if not hold.is_lease:
        return [f"which {_one(book, kind, id)} has" for kind, id in book.in_the_way(hold)]
    leases = book.leases(name)
    if len(leases) >= book.capacity(name):
        return [f"which {lease.words()} has" for lease in leases]
    return [f"for which {other.words()} comes first" for other in book.before(name, hold)]


def _one(book: Book, kind: str, id: str) -> str:
    return f"task {id}" if kind == "task" else book.holds[id].words()


def member_words(book: Book, member: Member) -> str:
    """A member of a ring, with what it holds or wants."""
    kind, id = member
    hold = book.holds.get(id)
    if kind == "task" or hold is None:
        return f"task {id}"
    names = ", ".join(hold.names)
    if hold.granted is not None:
        return f"{hold.words()}, holding {names}" if hold.is_lease else f"{hold.words()} of {names}"
    return f"{hold.words()}, waiting for {names}"
