"""Candidates of a choice, found by what a pattern already knows of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from rogue.prodigy._instance import Instance
from rogue.prodigy._patterns import BindingsPattern, ListPattern, Pattern, RuleBindings, plain
from rogue.prodigy._rules import Candidate
from rogue.prodigy._terms import Literal, Term, Variable

_Key = tuple[object, ...]
_Place = TypeVar("_Place", int, str)


class CandidateIndex:
    """Finds the candidates that a pattern may match, without a look at each every time."""

    def __init__(self, candidates: Sequence[Candidate]) -> None:
        self._candidates = candidates
        self._tables: dict[_Key, dict[_Key | None, list[Candidate]]] = {}

    def matching(self, pattern: Pattern, bindings: RuleBindings) -> Iterable[Candidate]:
        """Return all candidates that match, and perhaps some others."""
        match pattern:
            case Variable(name) if name in bindings:
                return self._table(("whole",), _whole).get((plain(bindings[name]),), ())
            case ListPattern(_, terms):
                known = _known(enumerate(terms), bindings)
                at = tuple(known)
                table = self._table(("args", *at), lambda c: _arguments(c, at))
                return table.get(tuple(known.values()), ())
            case BindingsPattern(pairs):
                values = _known(pairs, bindings)
                names = tuple(values)
                table = self._table(("bindings", *names), lambda c: _bindings(c, names))
                return table.get(tuple(values.values()), ())
        return self._candidates

    def _table(
        self, name: _Key, key: Callable[[Candidate], _Key | None]
    ) -> dict[_Key | None, list[Candidate]]:
        if name not in self._tables:
            made: dict[_Key | None, list[Candidate]] = {}
            for candidate in self._candidates:
                made.setdefault(key(candidate), []).append(candidate)
            self._tables[name] = made
        return self._tables[name]


def _known(places: Iterable[tuple[_Place, Term]], bindings: RuleBindings) -> dict[_Place, object]:
    """Return the places of which the value is known, with those values."""
    return {
        place: plain(bindings[term.name]) if isinstance(term, Variable) else term
        for place, term in places
        if not isinstance(term, Variable) or term.name in bindings
    }


def _whole(candidate: Candidate) -> _Key:
    return (plain(candidate),)


def _arguments(candidate: Candidate, at: tuple[int, ...]) -> _Key | None:
    args = candidate.args if isinstance(candidate, Literal | Instance) else ()
    return tuple(args[place] for place in at) if all(place < len(args) for place in at) else None


def _bindings(candidate: Candidate, names: tuple[str, ...]) -> _Key | None:
    if not isinstance(candidate, Instance) or not all(n in candidate.bindings for n in names):
        return None
    return tuple(candidate.bindings[name] for name in names)
