"""The meta-predicates of control rules: questions about the running search."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

from rogue.prodigy._domain import Operator
from rogue.prodigy._errors import FunctionError, ProdigyError
from rogue.prodigy._events import NodeView
from rogue.prodigy._functions import Function
from rogue.prodigy._instance import Instance
from rogue.prodigy._patterns import (
    ListPattern,
    Pattern,
    RuleBindings,
    RuleValue,
    as_literal,
    facts_matching,
    plain,
    resolved,
    unify,
    unify_all,
)
from rogue.prodigy._terms import Literal, Value, Variable
from rogue.prodigy._types import TypeSpec
from rogue.prodigy._view import SearchView

MetaPredicate = Callable[..., object]
"""A user's meta-predicate: ``function(search, *arguments)``.

An argument is a value, the name of an operator, an ``Instance``, a ``Literal``, a ``NodeView``, a
dict for bindings, a tuple for a list of another form, or a ``Variable`` where nothing is bound yet;
a literal and bindings keep a ``Variable`` in each of their places that is not bound. The function
returns a truth value, or an iterable of mappings that bind variables by name, angle brackets
included.
"""


class Kind(Enum):
    """What an argument of a meta-predicate stands for; it says how it is read and checked."""

    GOAL = auto()
    FACT = auto()
    OPERATOR = auto()
    INSTANCE = auto()
    BINDINGS = auto()
    NODE = auto()
    TYPE = auto()
    TERM = auto()
    ANY = auto()


@dataclass(frozen=True, slots=True)
class Question:
    """What a meta-predicate is asked: the search, the candidates, its arguments so far bound."""

    view: SearchView
    candidates: tuple[RuleValue, ...]
    arguments: tuple[Pattern | TypeSpec, ...]
    bindings: RuleBindings

    def pattern(self, at: int = 0) -> Pattern:
        """Return an argument that is no type."""
        argument = self.arguments[at]
        assert not isinstance(argument, TypeSpec)
        return argument

    def among(self, values: Iterable[RuleValue]) -> Iterator[RuleBindings]:
        """Yield the bindings with which the first argument is one of ``values``."""
        for value in values:
            yield from unify_all(self.pattern(), value, self.bindings)

    def if_so(self, holds: bool) -> Iterator[RuleBindings]:
        """Yield the bindings as they are if ``holds``."""
        if holds:
            yield self.bindings


Answer = Iterable[RuleBindings]


def _current_goal(q: Question) -> Answer:
    return q.among([q.view.goal] if q.view.goal else [])


def _candidate_goals(q: Question) -> tuple[Literal, ...]:
    listed = tuple(c for c in q.candidates if isinstance(c, Literal))
    return listed or q.view.pending_goals()


def _candidate_goal(q: Question) -> Answer:
    return q.among(_candidate_goals(q))


def _pending_goal(q: Question) -> Answer:
    return q.among(q.view.pending_goals())


def _candidate_operator(q: Question) -> Answer:
    return q.among(c for c in q.candidates if isinstance(c, Operator))


def _candidate_bindings(q: Question) -> Answer:
    return q.among(c for c in q.candidates if isinstance(c, Instance))


def _current_operator(q: Question) -> Answer:
    return q.among([q.view.operator] if q.view.operator else [])


def _candidate_applicable(q: Question) -> Answer:
    listed = [c for c in q.candidates if isinstance(c, Instance) and c.node]
    return q.among(listed or q.view.ready())


def _applicable(q: Question) -> Answer:
    return q.among(q.view.ready())


def _nodes(q: Question) -> list[NodeView]:
    return [c for c in q.candidates if isinstance(c, NodeView)]


def _candidate_node(q: Question) -> Answer:
    return q.among(_nodes(q))


def _newest_node(q: Question) -> Answer:
    return q.among(sorted(_nodes(q), key=lambda node: -node.number)[:1])


def _oldest_node(q: Question) -> Answer:
    return q.among(sorted(_nodes(q), key=lambda node: node.number)[:1])


def _expanded_goal(q: Question) -> Answer:
    return q.among(q.view.expanded_goals())


def _expanded_operator(q: Question) -> Answer:
    return q.among(q.view.tail())


def _is_op_for_goal(q: Question) -> Answer:
    for instance in q.view.tail():
        for found in q.among([instance]):
            if instance.goal is not None:
                yield from unify_all(q.pattern(1), instance.goal, found)


def _introduced_only_by(q: Question) -> Answer:
    for goal in dict.fromkeys((*q.view.expanded_goals(), *q.view.pending_goals())):
        needed_by = q.view.consumers(goal)
        if len(needed_by) == 1:
            for found in q.among([goal]):
                yield from unify_all(q.pattern(1), needed_by[0], found)


def _top_level(q: Question) -> Answer:
    return q.among(q.view.goals())


def _known(q: Question) -> Answer:
    literal = as_literal(q.pattern(), q.bindings)
    return [] if literal is None else _true(q, literal)


def _true(q: Question, literal: ListPattern) -> Answer:
    known = tuple(None if isinstance(term, Variable) else term for term in literal.terms)
    rows = q.view.state.matching(literal.name, known)
    found = facts_matching(literal, iter(rows), q.bindings)
    return found if literal.positive else q.if_so(not any(True for _ in found))


def _false_in_state(q: Question) -> Answer:
    literal = as_literal(q.pattern(), q.bindings)
    return q.if_so(literal is not None and not any(True for _ in _true(q, literal)))


def _type_of_object(q: Question) -> Answer:
    spec = q.arguments[1]
    assert isinstance(spec, TypeSpec)
    what = resolved(q.pattern(), q.bindings)
    if isinstance(what, Variable):
        return q.among(q.view.objects.of(spec))
    return q.if_so(isinstance(what, Value) and q.view.objects.is_a(what, spec))


def _diff(q: Question) -> Answer:
    is_known = isinstance(resolved(q.pattern(), q.bindings), RuleValue)
    other = resolved(q.pattern(1), q.bindings)
    if not is_known or not isinstance(other, RuleValue):
        return []
    return q.if_so(unify(q.pattern(), other, q.bindings) is None)


def _same(q: Question) -> Answer:
    one, other = q.pattern(0), q.pattern(1)
    for pattern, against in ((one, other), (other, one)):
        known = resolved(against, q.bindings)
        if isinstance(known, RuleValue):
            found = unify(pattern, known, q.bindings)
            return [] if found is None else [found]
    return []


def _only_one_goal(q: Question) -> Answer:
    return q.if_so(len(_candidate_goals(q)) == 1)


class BuiltIn(NamedTuple):
    """A meta-predicate of PRODIGY: what its arguments stand for, and what it answers."""

    kinds: tuple[Kind, ...]
    answer: Callable[[Question], Answer]


BUILT_IN: Mapping[str, BuiltIn] = {
    "current-goal": BuiltIn((Kind.GOAL,), _current_goal),
    "candidate-goal": BuiltIn((Kind.GOAL,), _candidate_goal),
    "pending-goal": BuiltIn((Kind.GOAL,), _pending_goal),
    "expanded-goal": BuiltIn((Kind.GOAL,), _expanded_goal),
    "on-goal-stack": BuiltIn((Kind.GOAL,), _expanded_goal),
    "is-top-level-goal": BuiltIn((Kind.GOAL,), _top_level),
    "only-one-candidate-goal": BuiltIn((), _only_one_goal),
    "candidate-operator": BuiltIn((Kind.OPERATOR,), _candidate_operator),
    "current-operator": BuiltIn((Kind.OPERATOR,), _current_operator),
    "current-ops": BuiltIn((Kind.OPERATOR,), _current_operator),
    "candidate-bindings": BuiltIn((Kind.BINDINGS,), _candidate_bindings),
    "candidate-applicable-op": BuiltIn((Kind.INSTANCE,), _candidate_applicable),
    "applicable-operator": BuiltIn((Kind.INSTANCE,), _applicable),
    "expanded-operator": BuiltIn((Kind.INSTANCE,), _expanded_operator),
    "is-op-for-goal": BuiltIn((Kind.INSTANCE, Kind.GOAL), _is_op_for_goal),
    "goal-introduced-only-by-op": BuiltIn((Kind.GOAL, Kind.INSTANCE), _introduced_only_by),
    "candidate-node": BuiltIn((Kind.NODE,), _candidate_node),
    "newest-candidate-node": BuiltIn((Kind.NODE,), _newest_node),
    "oldest-candidate-node": BuiltIn((Kind.NODE,), _oldest_node),
    "known": BuiltIn((Kind.FACT,), _known),
    "true-in-state": BuiltIn((Kind.FACT,), _known),
    "gen-from-pred": BuiltIn((Kind.FACT,), _known),
    "false-in-state": BuiltIn((Kind.FACT,), _false_in_state),
    "type-of-object": BuiltIn((Kind.TERM, Kind.TYPE), _type_of_object),
    "type-of-object-gen": BuiltIn((Kind.TERM, Kind.TYPE), _type_of_object),
    "diff": BuiltIn((Kind.TERM, Kind.TERM), _diff),
    "same": BuiltIn((Kind.TERM, Kind.TERM), _same),
}
"""By name."""


def ask_test(name: str, function: Function, q: Question) -> Iterator[RuleBindings]:
    """Ask a function of the domain; it does not hold while an argument is not bound.

    Raises:
        FunctionError: If it raises.
    """
    arguments = tuple(resolved(q.pattern(at), q.bindings) for at in range(len(q.arguments)))
    if any(isinstance(argument, Variable) for argument in arguments):
        return
    try:
        holds = bool(function(*arguments))
    except Exception as error:
        raise FunctionError(name, arguments, f"raised {error!r}") from error
    yield from q.if_so(holds)


def ask_user(name: str, function: MetaPredicate, q: Question) -> Iterator[RuleBindings]:
    """Ask a user's meta-predicate.

    Raises:
        FunctionError: If it raises, or its answer is no truth value and no mappings.
    """
    arguments = tuple(resolved(q.pattern(at), q.bindings) for at in range(len(q.arguments)))
    try:
        answer = function(q.view, *arguments)
        answers = list(answer) if isinstance(answer, Iterable) else bool(answer)
    except ProdigyError:
        raise
    except Exception as error:
        raise FunctionError(name, arguments, f"raised {error!r}") from error
    if isinstance(answers, bool):
        yield from q.if_so(answers)
        return
    for found in answers:
        if not isinstance(found, Mapping) or not all(
            isinstance(value, RuleValue) for value in found.values()
        ):
            raise FunctionError(name, arguments, f"gave {found!r}, expected bindings")
        agrees = all(k not in q.bindings or plain(q.bindings[k]) == v for k, v in found.items())
        if agrees:
            yield {**found, **q.bindings}
