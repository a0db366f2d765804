"""States of the world."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rogue.prodigy._terms import Literal, Value

Tuples = frozenset[tuple[Value, ...]]
_NONE: Tuples = frozenset()


class State:
    """An immutable set of true facts; what is not in it is false.

    Predicates that do not change are shared between a state and its successors.
    """

    __slots__ = ("_facts", "_fingerprint")

    def __init__(self, facts: Iterable[Literal] = ()) -> None:
        grouped: dict[str, set[tuple[Value, ...]]] = {}
        for fact in facts:
            if fact.positive:
                grouped.setdefault(fact.predicate, set()).add(fact.args)
        self._facts: Mapping[str, Tuples] = {p: frozenset(a) for p, a in grouped.items()}
        self._fingerprint = 0
        for predicate, tuples in self._facts.items():
            self._fingerprint ^= _mix(predicate, tuples)

    def holds(self, literal: Literal) -> bool:
        """Say whether ``literal`` is true."""
        return (literal.args in self._facts.get(literal.predicate, _NONE)) == literal.positive

    def tuples(self, predicate: str) -> Tuples:
        """Return the arguments of the true facts of ``predicate``."""
        return self._facts.get(predicate, _NONE)

    def facts(self) -> Iterator[Literal]:
        """Yield all true facts, sorted."""
        for predicate in sorted(self._facts):
            for args in sorted(self._facts[predicate], key=str):
                yield Literal(predicate, args)

    def changed(self, added: Iterable[Literal], deleted: Iterable[Literal] = ()) -> State:
        """Return the state after ``deleted``, then ``added``."""
        drop: dict[str, set[tuple[Value, ...]]] = {}
        gain: dict[str, set[tuple[Value, ...]]] = {}
        for fact in deleted:
            drop.setdefault(fact.predicate, set()).add(fact.args)
        for fact in added:
            gain.setdefault(fact.predicate, set()).add(fact.args)
        facts = dict(self._facts)
        fingerprint = self._fingerprint
        for predicate in drop.keys() | gain.keys():
            before = facts.get(predicate, _NONE)
            after = (before - drop.get(predicate, _NONE)) | gain.get(predicate, _NONE)
            fingerprint ^= _mix(predicate, before ^ after)
            facts[predicate] = frozenset(after)
        return State._of({p: t for p, t in facts.items() if t}, fingerprint)

    @classmethod
    def _of(cls, facts: Mapping[str, Tuples], fingerprint: int) -> State:
        self = cls.__new__(cls)
        self._facts = facts
        self._fingerprint = fingerprint
        return self

    def difference(self, other: State) -> Iterator[Literal]:
        """Yield, as positive literals, the facts whose truth is not the same in ``other``."""
        for predicate in self._facts.keys() | other._facts.keys():
            mine, theirs = self.tuples(predicate), other.tuples(predicate)
            if mine is not theirs:
                yield from (Literal(predicate, args) for args in mine ^ theirs)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, State):
            return NotImplemented
        return self._fingerprint == other._fingerprint and self._facts == other._facts

    def __hash__(self) -> int:
        return self._fingerprint

    def __contains__(self, literal: Literal) -> bool:
        return self.holds(literal)


def _mix(predicate: str, tuples: Iterable[tuple[Value, ...]]) -> int:
    mixed = 0
    for args in tuples:
        mixed ^= hash((predicate, args))
    return mixed
