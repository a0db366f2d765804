"""An independent check of plans.

It shares with the search only the values (domain, state, expressions): it evaluates
preconditions as written and enumerates effects object by object.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rogue.prodigy._domain import Operator
from rogue.prodigy._events import StepView
from rogue.prodigy._expressions import (
    And,
    Call,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
)
from rogue.prodigy._functions import Generator
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
        wrong = _wrong_value(problem, facts, operator, bindings)
        if wrong:
            return PlanFault(at, f"{step}: {wrong}")
        if not _holds(problem, facts, operator.precondition, bindings):
            return PlanFault(at, f"{step}: its precondition is false")
        facts = _after(problem, facts, operator, bindings)
    cases = _cases(problem, facts, problem.variables, {})
    if any(_holds(problem, facts, problem.goal, case) for case in cases):
        return None
    return PlanFault(len(steps), "the goal is not reached")


def _wrong_value(
    problem: Problem, facts: _Facts, operator: Operator, bindings: dict[str, Value]
) -> str:
    for spec in operator.variables:
        if spec.name not in bindings:
            return f"{spec.name} is not bound"
        value = bindings[spec.name]
        if not _is_of(problem, spec, value):
            return f"{spec.name} is {value}, which is no {spec.types}"
        for call in spec.calls:
            # What was true when the value was chosen may have changed since.
            if call.pattern is None and not _passes(problem, facts, call, spec, bindings):
                return f"{spec.name} is {value}, which does not pass {call.function}"
    return ""


def _is_of(problem: Problem, spec: VariableSpec, value: Value) -> bool:
    infinite, functions = problem.domain.types.infinite, problem.domain.functions
    tests = (functions[infinite[name]] for name in spec.types.names if name in infinite)
    return problem.objects.is_a(value, spec.types) or any(test(value) for test in tests)


def _passes(
    problem: Problem, facts: _Facts, call: Call, spec: VariableSpec, case: dict[str, Value]
) -> bool:
    if call.pattern is not None:
        literal = call.pattern.ground(case)
        return (literal.predicate, literal.args) in facts
    function = problem.domain.functions[call.function]
    if not isinstance(function, Generator):
        return bool(function(*(_value(t, case) for t in call.terms)))
    own = Variable(spec.name)
    args = (None if t == own else _value(t, case) for t in call.terms)
    return case[spec.name] in function(*args)


def _cases(
    problem: Problem,
    facts: _Facts,
    specs: tuple[VariableSpec, ...],
    bindings: dict[str, Value],
) -> Iterator[dict[str, Value]]:
    cases = [bindings]
    for spec in specs:
        cases = [
            {**case, spec.name: value}
            for case in cases
            for value in _domain_of(problem, facts, spec, case)
        ]
    for case in cases:
        if all(_passes(problem, facts, c, s, case) for s in specs for c in s.calls):
            yield case


def _domain_of(
    problem: Problem, facts: _Facts, spec: VariableSpec, case: dict[str, Value]
) -> Iterator[Value]:
    yield from problem.objects.of(spec.types)
    if any(name in problem.domain.types.infinite for name in spec.types.names):
        known = dict.fromkeys(value for _, args in facts for value in args)
        for call in spec.calls:
            function = problem.domain.functions.get(call.function)
            if isinstance(function, Generator):
                own = Variable(spec.name)
                args = (None if t == own else _value(t, case) for t in call.terms)
                known.update(dict.fromkeys(function(*args)))
        yield from (v for v in known if v not in problem.objects and _is_of(problem, spec, v))


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
            cases = _cases(problem, facts, specs, bindings)
            return any(_holds(problem, facts, body, case) for case in cases)
        case Forall(specs, body):
            cases = _cases(problem, facts, specs, bindings)
            return all(_holds(problem, facts, body, case) for case in cases)


def _after(
    problem: Problem, facts: _Facts, operator: Operator, bindings: dict[str, Value]
) -> _Facts:
    added: set[Literal] = set()
    deleted: set[Literal] = set()
    for effect in operator.effects:
        free = tuple(v for v in effect.variables if v.name not in bindings)
        for case in _cases(problem, facts, free, bindings):
            if _holds(problem, facts, effect.condition, case):
                (added if effect.adds else deleted).add(effect.atom.ground(case))
    gone = {(f.predicate, f.args) for f in deleted}
    return (facts - gone) | {(f.predicate, f.args) for f in added}
