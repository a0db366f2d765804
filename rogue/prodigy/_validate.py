"""An independent check of plans.

It shares with the search only the values (domain, state, expressions): it evaluates
preconditions as written and enumerates effects object by object.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rogue.prodigy._domain import Operator
from rogue.prodigy._events import StepView
from rogue.prodigy._expressions import (
    And,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
)
from rogue.prodigy._problem import Problem
from rogue.prodigy._terms import Literal, Term, Value, Variable

_Facts = set[tuple[str, tuple[Value, ...]]]


@dataclass(frozen=True, slots=True)
class PlanFault:
    """What is wrong with a plan: the step's index from 0, or its length for the goal."""

    step: int
    problem: str


def validate_plan(problem: Problem, plan: Iterable[StepView]) -> PlanFault | None:
    """Return the first fault of a plan, None if it is valid and reaches the goal."""
    facts: _Facts = {(f.predicate, f.args) for f in problem.state.facts()}
    steps = tuple(plan)
    for at, step in enumerate(steps):
        operator = problem.domain.operator(step.operator)
        bindings = dict(step.bindings)
        if operator is None:
            return PlanFault(at, f"no operator named {step.operator}")
        wrong = _wrong_value(problem, operator, bindings)
        if wrong:
            return PlanFault(at, f"{step}: {wrong}")
        if not _holds(problem, facts, operator.precondition, bindings):
            return PlanFault(at, f"{step}: its precondition is false")
        facts = _after(problem, facts, operator, bindings)
    cases = _cases(problem, problem.variables, {})
    if any(_holds(problem, facts, problem.goal, case) for case in cases):
        return None
    return PlanFault(len(steps), "the goal is not reached")


def _wrong_value(problem: Problem, operator: Operator, bindings: dict[str, Value]) -> str:
    for spec in operator.variables:
        if spec.name not in bindings:
            return f"{spec.name} is not bound"
        infinite = any(name in problem.domain.types.infinite for name in spec.types.names)
        if not infinite and not problem.objects.is_a(bindings[spec.name], spec.types):
            return f"{spec.name} is {bindings[spec.name]}, which is no {spec.types}"
    return ""


def _cases(
    problem: Problem, specs: tuple[VariableSpec, ...], bindings: dict[str, Value]
) -> Iterator[dict[str, Value]]:
    names = [spec.name for spec in specs]
    for values in itertools.product(*(problem.objects.of(spec.types) for spec in specs)):
        case = {**bindings, **dict(zip(names, values, strict=True))}
        tests = [c for spec in specs for c in spec.calls if c.pattern is None]
        functions = problem.domain.functions
        if all(functions[c.function](*(_value(t, case) for t in c.terms)) for c in tests):
            yield case


def _value(term: Term, bindings: dict[str, Value]) -> Value:
    return bindings[term.name] if isinstance(term, Variable) else term


def _holds(
    problem: Problem, facts: _Facts, expression: Expression, bindings: dict[str, Value]
) -> bool:
    match expression:
        case Holds(atom):
            literal = atom.ground(bindings)
            return (literal.predicate, literal.args) in facts
        case Not(part):
            return not _holds(problem, facts, part, bindings)
        case And(parts):
            return all(_holds(problem, facts, part, bindings) for part in parts)
        case Or(parts):
            return any(_holds(problem, facts, part, bindings) for part in parts)
        case Exists(specs, body):
            return any(_holds(problem, facts, body, c) for c in _cases(problem, specs, bindings))
        case Forall(specs, body):
            return all(_holds(problem, facts, body, c) for c in _cases(problem, specs, bindings))


def _after(
    problem: Problem, facts: _Facts, operator: Operator, bindings: dict[str, Value]
) -> _Facts:
    added: set[Literal] = set()
    deleted: set[Literal] = set()
    for effect in operator.effects:
        free = tuple(v for v in effect.variables if v.name not in bindings)
        for case in _cases(problem, free, bindings):
            if _holds(problem, facts, effect.condition, case):
                (added if effect.adds else deleted).add(effect.atom.ground(case))
    gone = {(f.predicate, f.args) for f in deleted}
    return (facts - gone) | {(f.predicate, f.args) for f in added}
