"""An independent check of plans.

It shares with the search only the values (domain, state, expressions): it evaluates
preconditions as written, enumerates effects object by object, and works out by itself what
follows by inference rules: what eager rules say, fired once after each step, and everything that
follows by lazy rules.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rogue.prodigy._domain import Operator
from rogue.prodigy._events import StepView
from rogue.prodigy._problem import Problem
from rogue.prodigy._simulate import Facts, after, cases, holds, is_of, passes, start
from rogue.prodigy._terms import Value


@dataclass(frozen=True, slots=True)
class PlanFault:
    """What is wrong with a plan: the step's index from 0, or its length for the goal."""

    step: int
    problem: str


def validate_plan(problem: Problem, plan: Iterable[StepView]) -> PlanFault | None:
    """Return the first fault of a plan, None if it is valid and reaches the goal."""
    world = start(problem)
    steps = tuple(plan)
    for at, step in enumerate(steps):
        operator = problem.domain.operator(step.operator)
        if operator is None:
            return PlanFault(at, f"no operator named {step.operator}")
        own = _chosen(problem, operator)
        bindings = {name: value for name, value in step.bindings if name in own}
        wrong = _wrong_value(problem, world.facts, operator, bindings)
        if wrong:
            return PlanFault(at, f"{step}: {wrong}")
        if not holds(problem, world.facts, operator.precondition, bindings):
            return PlanFault(at, f"{step}: its precondition is false")
        world = after(problem, world, operator, bindings)
    variables = cases(problem, world.facts, problem.variables, {})
    if any(holds(problem, world.facts, problem.goal, case) for case in variables):
        return None
    return PlanFault(len(steps), "the goal is not reached")


def _chosen(problem: Problem, operator: Operator) -> set[str]:
    """Return the variables that a step binds; the others of its effects range over all."""
    infinite = problem.domain.types.infinite
    local = (spec for effect in operator.effects for spec in effect.variables)
    numbers = {spec.name for spec in local if any(name in infinite for name in spec.types.names)}
    return {spec.name for spec in operator.variables} | set(operator.params) | numbers


def _wrong_value(
    problem: Problem, facts: Facts, operator: Operator, bindings: dict[str, Value]
) -> str:
    for spec in operator.variables:
        if spec.name not in bindings:
            return f"{spec.name} is not bound"
        value = bindings[spec.name]
        if not is_of(problem, spec, value):
            return f"{spec.name} is {value}, which is no {spec.types}"
        for call in spec.calls:
            # What was true when the value was chosen may have changed since.
            if call.pattern is None and not passes(problem, facts, call, spec, bindings):
                return f"{spec.name} is {value}, which does not pass {call.function}"
    return ""
