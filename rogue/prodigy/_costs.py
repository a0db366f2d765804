"""Costs of actions: ``(increase (total-cost) ...)`` over functions that do not change."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from rogue.prodigy._events import StepView
from rogue.prodigy._instance import Instance
from rogue.prodigy._terms import Atom, Bindings, Literal

TOTAL_COST = "total-cost"


@dataclass(frozen=True, slots=True)
class Amount:
    """A number."""

    value: float


@dataclass(frozen=True, slots=True)
class Lookup:
    """The value of a function of the problem."""

    function: Atom


@dataclass(frozen=True, slots=True)
class Combined:
    """A sum or a product."""

    operation: str
    parts: tuple[Cost, ...]


Cost = Amount | Lookup | Combined


def has_value(function: Atom) -> Atom:
    """Return the static atom that a function has a value for some arguments."""
    return Atom(f"{function.predicate}=", function.terms)


def lookups(cost: Cost) -> Iterator[Atom]:
    """Yield the functions whose values a cost needs."""
    match cost:
        case Lookup(function):
            yield function
        case Combined(parts=parts):
            for part in parts:
                yield from lookups(part)


@dataclass(frozen=True, slots=True)
class Costs:
    """What the actions of one problem cost.

    Attributes:
        actions: Cost of each action that has one, by name; others cost nothing.
        values: Values of functions, by the function with its arguments.
    """

    actions: Mapping[str, Cost] = field(default_factory=dict)
    values: Mapping[Literal, float] = field(default_factory=dict)

    def of(self, step: StepView | Instance) -> float:
        """Return the cost of one step; 1 for each step of a domain without costs."""
        if not self.actions:
            return 1.0
        name = step.operator if isinstance(step, StepView) else step.name
        cost = self.actions.get(name)
        return 0.0 if cost is None else self._value(cost, dict(step.bindings))

    def total(self, plan: Iterable[StepView]) -> float:
        """Return the cost of a plan."""
        return math.fsum(map(self.of, plan))

    def _value(self, cost: Cost, bindings: Bindings) -> float:
        match cost:
            case Amount(value):
                return value
            case Lookup(function):
                return self.values[function.ground(bindings)]
            case Combined(operation, parts):
                values = [self._value(part, bindings) for part in parts]
                return math.fsum(values) if operation == "+" else math.prod(values)
