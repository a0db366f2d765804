"""The meta-predicates of control rules: questions about the running search."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from rogue.prodigy._domain import Operator
from rogue.prodigy._errors import FunctionError
from rogue.prodigy._instance import Instance
from rogue.prodigy._patterns import (
    ListPattern,
    Pattern,
    RuleBindings,
    RuleValue,
    facts_matching,
    unify,
)
from rogue.prodigy._terms import Literal, Variable
from rogue.prodigy._view import SearchView

MetaPredicate = Callable[..., object]
"""A user's meta-predicate: ``function(search, *arguments)``.

Arguments are values, literals for goals, or a ``Variable`` where unbound. It returns a truth
value, or an iterable of mappings that bind variables by name, angle brackets included.
"""


@dataclass(frozen=True, slots=True)
class Question:
    """What a meta-predicate is asked: the search, the candidates, its arguments so far bound."""

    view: SearchView
    candidates: tuple[RuleValue, ...]
    arguments: tuple[Pattern, ...]
    bindings: RuleBindings

    def among(self, values: Iterable[RuleValue]) -> Iterator[RuleBindings]:
        """Yield the bindings with which the first argument is one of ``values``."""
        for value in values:
            found = unify(self.arguments[0], value, self.bindings)
            if found is not None:
                yield found


Answer = Iterable[RuleBindings]


def _current_goal(q: Question) -> Answer:
    return q.among([q.view.goal] if q.view.goal else [])


def _candidate_goal(q: Question) -> Answer:
    listed = [c for c in q.candidates if isinstance(c, Literal)]
    return q.among(listed or q.view.pending_goals())


def _candidate(q: Question) -> Answer:
    return q.among(q.candidates)


def _current_operator(q: Question) -> Answer:
    return q.among([q.view.operator] if q.view.operator else [])


def _candidate_applicable(q: Question) -> Answer:
    listed = [c for c in q.candidates if isinstance(c, Instance)]
    return q.among(listed or q.view.ready())


def _applicable(q: Question) -> Answer:
    return q.among(q.view.ready())


def _expanded_goal(q: Question) -> Answer:
    return q.among(q.view.expanded_goals())


def _expanded_operator(q: Question) -> Answer:
    return q.among(q.view.tail())


def _top_level(q: Question) -> Answer:
    return q.among(q.view.goals())


def _known(q: Question) -> Answer:
    pattern = q.arguments[0]
    if isinstance(pattern, ListPattern) and pattern.positive:
        tuples = sorted(q.view.state.tuples(pattern.name), key=str)
        return facts_matching(pattern, iter(tuples), q.bindings)
    return _false_in_state(q)


def _false_in_state(q: Question) -> Answer:
    pattern = q.arguments[0]
    if not isinstance(pattern, ListPattern):
        literal = q.bindings.get(pattern.name) if isinstance(pattern, Variable) else None
        holds = isinstance(literal, Literal) and not q.view.state.holds(literal)
        return [q.bindings] if holds else []
    tuples = iter(q.view.state.tuples(pattern.name))
    return [] if any(True for _ in facts_matching(pattern, tuples, q.bindings)) else [q.bindings]


def _type_of_object(q: Question) -> Answer:
    what, kind = q.arguments[:2]
    return [
        found
        for name in q.view.objects_of(str(kind))
        if (found := unify(what, name, q.bindings)) is not None
    ]


def _diff(q: Question) -> Answer:
    one, other = (_resolved(a, q.bindings) for a in q.arguments[:2])
    return [q.bindings] if one != other else []


def _only_one_goal(q: Question) -> Answer:
    goals = [c for c in q.candidates if isinstance(c, Literal)] or q.view.pending_goals()
    return [q.bindings] if len(goals) == 1 else []


BUILT_IN: Mapping[str, tuple[int, Callable[[Question], Answer]]] = {
    "current-goal": (1, _current_goal),
    "candidate-goal": (1, _candidate_goal),
    "candidate-operator": (1, _candidate),
    "candidate-bindings": (1, _candidate),
    "candidate-applicable-op": (1, _candidate_applicable),
    "applicable-operator": (1, _applicable),
    "current-operator": (1, _current_operator),
    "current-ops": (1, _current_operator),
    "expanded-goal": (1, _expanded_goal),
    "on-goal-stack": (1, _expanded_goal),
    "expanded-operator": (1, _expanded_operator),
    "is-top-level-goal": (1, _top_level),
    "only-one-candidate-goal": (0, _only_one_goal),
    "known": (1, _known),
    "true-in-state": (1, _known),
    "false-in-state": (1, _false_in_state),
    "type-of-object": (2, _type_of_object),
    "type-of-object-gen": (2, _type_of_object),
    "diff": (2, _diff),
}
"""Number of arguments and meaning, by name."""


def ask_user(name: str, function: MetaPredicate, q: Question) -> Iterator[RuleBindings]:
    """Ask a user's meta-predicate.

    Raises:
        FunctionError: If it raises, or its answer is no truth value and no mappings.
    """
    arguments = tuple(_resolved(a, q.bindings) for a in q.arguments)
    try:
        answer = function(q.view, *arguments)
    except Exception as error:
        raise FunctionError(name, arguments, f"raised {error!r}") from error
    if isinstance(answer, Iterable):
        for found in answer:
            if not isinstance(found, Mapping):
                raise FunctionError(name, arguments, f"gave {found!r}, expected bindings")
            yield {**q.bindings, **found}
    elif answer:
        yield q.bindings


def _resolved(pattern: Pattern, bindings: RuleBindings) -> object:
    if isinstance(pattern, Variable):
        found = bindings.get(pattern.name, pattern)
        return found.name if isinstance(found, Operator) else found
    if isinstance(pattern, ListPattern):
        terms = tuple(_resolved(term, bindings) for term in pattern.terms)
        if not any(isinstance(term, Variable) for term in terms):
            return Literal(pattern.name, terms, pattern.positive)  # type: ignore[arg-type]
    return pattern
