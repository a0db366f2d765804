"""In which order inference rules have to be worked out, and what has to be known in full."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rogue.prodigy._domain import Domain, InferenceRule, Operator
from rogue.prodigy._errors import InferenceError
from rogue.prodigy._expressions import (
    TRUE,
    And,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
    atoms,
)


def mentioned(operator: Operator) -> set[str]:
    """Return the predicates of the conditions of an operator or rule."""
    conditions = (operator.precondition, *(e.condition for e in operator.effects))
    specs = (*operator.variables, *(v for e in operator.effects for v in e.variables))
    return {atom.predicate for c in conditions for atom in atoms(c)} | _generated(specs)


def _generated(specs: Iterable[VariableSpec]) -> set[str]:
    return {c.pattern.predicate for v in specs for c in v.calls if c.pattern is not None}


def consulted(domain: Domain, goals: Iterable[Expression]) -> set[str]:
    """Return the predicates whose being false, or true without being a goal, matters somewhere."""
    names: set[str] = set()
    for expression in goals:
        names |= _negated(expression)
    for operator in (*domain.operators, *domain.inference_rules):
        names |= _negated(operator.precondition) | _generated(operator.variables)
        for effect in operator.effects:
            names |= {atom.predicate for atom in atoms(effect.condition)}
            names |= _generated(effect.variables)
    return names


def _negated(expression: Expression) -> set[str]:
    return {name for name, positive in _signed(expression, positive=True) if not positive}


def _signed(expression: Expression, *, positive: bool) -> Iterator[tuple[str, bool]]:
    match expression:
        case Holds(atom):
            yield atom.predicate, positive
        case Not(part):
            yield from _signed(part, positive=not positive)
        case Exists(specs, part) | Forall(specs, part):
            yield from ((name, False) for name in _generated(specs))
            yield from _signed(part, positive=positive)
        case And(parts) | Or(parts):
            for part in parts:
                yield from _signed(part, positive=positive)


def in_strata(rules: list[InferenceRule]) -> list[list[InferenceRule]]:
    """Return rules in layers, such that a layer only asks for the absence of what is below it.

    Raises:
        InferenceError: If what a rule infers hangs on its not being inferred.
    """
    height = {effect.atom.predicate: 0 for rule in rules for effect in rule.effects}
    for _ in range(len(height) + 1):
        raised = {
            name: max(height[name], level)
            for rule in rules
            for level in [_least(rule, height)]
            for name in {effect.atom.predicate for effect in rule.effects}
            if level > height[name]
        }
        if not raised:
            layers = sorted({_top(rule, height) for rule in rules})
            return [[r for r in rules if _top(r, height) == layer] for layer in layers]
        for name, level in raised.items():
            height[name] = max(height[name], level)
    raise InferenceError(tuple(rule.name for rule in rules))


def _top(rule: InferenceRule, height: dict[str, int]) -> int:
    return max((height[effect.atom.predicate] for effect in rule.effects), default=0)


def _least(rule: InferenceRule, height: dict[str, int]) -> int:
    """Return the lowest layer in which a rule may stand as its conditions are."""
    conditions = [rule.precondition, *(e.condition for e in rule.effects if e.condition != TRUE)]
    signed = [pair for c in conditions for pair in _signed(c, positive=True)]
    return max((height[n] + (not positive) for n, positive in signed if n in height), default=0)
