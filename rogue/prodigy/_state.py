"""States of the world."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, KeysView, Mapping

from rogue.prodigy._relation import Pattern, Relation, Row
from rogue.prodigy._terms import Literal

_NONE = Relation()


class State:
    """An immutable set of true facts; what is not in it is false.

    Predicates that do not change are shared between a state and its successors.
    """

    __slots__ = ("_facts", "_fingerprint")

    def __init__(self, facts: Iterable[Literal] = ()) -> None:
        grouped: dict[str, list[Row]] = {}
        for fact in facts:
            if fact.positive:
                grouped.setdefault(fact.predicate, []).append(fact.args)
        self._facts: Mapping[str, Relation] = {p: Relation(rows) for p, rows in grouped.items()}
        self._fingerprint = 0
        for predicate, relation in self._facts.items():
            self._fingerprint ^= _mix(predicate, relation.rows())

    def holds(self, literal: Literal) -> bool:
        """Say whether ``literal`` is true."""
        return (literal.args in self._facts.get(literal.predicate, _NONE)) == literal.positive

    def tuples(self, predicate: str) -> KeysView[Row]:
        """Return the arguments of the true facts of ``predicate``, in the order they came."""
        return self._facts.get(predicate, _NONE).rows()

    def matching(self, predicate: str, pattern: Pattern) -> Collection[Row]:
        """Return arguments of true facts: all that match ``pattern``, and few others."""
        return self._facts.get(predicate, _NONE).matching(pattern)

    def facts(self) -> Iterator[Literal]:
        """Yield all true facts, sorted."""
        for predicate in sorted(self._facts):
            for args in sorted(self.tuples(predicate), key=str):
                yield Literal(predicate, args)

    def changed(self, added: Iterable[Literal], deleted: Iterable[Literal] = ()) -> State:
        """Return the state after ``deleted``, then ``added``."""
        drop: dict[str, dict[Row, None]] = {}
        gain: dict[str, dict[Row, None]] = {}
        for fact in deleted:
            drop.setdefault(fact.predicate, {})[fact.args] = None
        for fact in added:
            gain.setdefault(fact.predicate, {})[fact.args] = None
        facts = dict(self._facts)
        fingerprint = self._fingerprint
        for predicate in drop | gain:
            before = facts.get(predicate, _NONE)
            new = gain.get(predicate, {})
            gone = [row for row in drop.get(predicate, ()) if row in before and row not in new]
            came = [row for row in new if row not in before]
            if gone or came:
                fingerprint ^= _mix(predicate, (*gone, *came))
                facts[predicate] = before.changed(gone, came)
        return State._of({p: r for p, r in facts.items() if len(r)}, fingerprint)

    @classmethod
    def _of(cls, facts: Mapping[str, Relation], fingerprint: int) -> State:
        self = cls.__new__(cls)
        self._facts = facts
        self._fingerprint = fingerprint
        return self

    def difference(self, other: State) -> Iterator[Literal]:
        """Yield, as positive literals, the facts whose truth is not the same in ``other``."""
        for predicate in dict.fromkeys([*self._facts, *other._facts]):
            mine, theirs = self._facts.get(predicate, _NONE), other._facts.get(predicate, _NONE)
            if mine is not theirs:
                yield from (Literal(predicate, args) for args in mine.difference(theirs))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, State):
            return NotImplemented
        return self._fingerprint == other._fingerprint and self._facts == other._facts

    def __hash__(self) -> int:
        return self._fingerprint

    def __contains__(self, literal: Literal) -> bool:
        return self.holds(literal)


def _mix(predicate: str, rows: Iterable[Row]) -> int:
    mixed = 0
    for args in rows:
        mixed ^= hash((predicate, args))
    return mixed
