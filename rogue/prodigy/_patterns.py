"""Patterns of control rules, matched against goals, operators and their instances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rogue.prodigy._domain import Operator
from rogue.prodigy._instance import Instance
from rogue.prodigy._terms import Literal, Value, Variable

RuleValue = Value | Literal | Operator | Instance
RuleBindings = Mapping[str, RuleValue]


@dataclass(frozen=True, slots=True)
class ListPattern:
    """``(name term ...)``: a literal, or an operator with its parameters."""

    name: str
    terms: tuple[Variable | Value, ...]
    positive: bool = True


@dataclass(frozen=True, slots=True)
class BindingsPattern:
    """``((<v> . term) ...)``: values of an operator's variables."""

    pairs: tuple[tuple[str, Variable | Value], ...]


Pattern = Variable | Value | ListPattern | BindingsPattern


def unify(pattern: Pattern, value: RuleValue, bindings: RuleBindings) -> RuleBindings | None:
    """Return ``bindings`` extended so that ``pattern`` is ``value``, or None."""
    match pattern:
        case Variable(name):
            if name not in bindings:
                return {**bindings, name: value}
            return bindings if _plain(bindings[name]) == _plain(value) else None
        case ListPattern(name, terms, positive):
            args = _args_of(value, name, positive=positive)
            return None if args is None else _unify_all(terms, args, bindings)
        case BindingsPattern(pairs):
            return _unify_pairs(pairs, value, bindings)
    return bindings if pattern == _plain(value) else None


def _args_of(value: RuleValue, name: str, *, positive: bool) -> tuple[Value, ...] | None:
    if isinstance(value, Literal):
        return value.args if (value.predicate, value.positive) == (name, positive) else None
    if isinstance(value, Instance) and value.name == name and positive:
        return value.args
    return None


def _plain(value: RuleValue) -> object:
    return value.name if isinstance(value, Operator) else value


def _unify_all(
    terms: tuple[Variable | Value, ...], args: tuple[Value, ...], bindings: RuleBindings
) -> RuleBindings | None:
    if len(terms) != len(args):
        return None
    found: RuleBindings | None = bindings
    for term, value in zip(terms, args, strict=True):
        found = unify(term, value, found) if found is not None else None
    return found


def _unify_pairs(
    pairs: tuple[tuple[str, Variable | Value], ...], value: RuleValue, bindings: RuleBindings
) -> RuleBindings | None:
    found: RuleBindings | None = bindings
    for name, term in pairs:
        if not isinstance(value, Instance) or name not in value.bindings or found is None:
            return None
        found = unify(term, value.bindings[name], found)
    return found


def facts_matching(
    pattern: ListPattern, tuples: Iterator[tuple[Value, ...]], bindings: RuleBindings
) -> Iterator[RuleBindings]:
    """Yield ``bindings`` extended by each of the arguments that the pattern fits."""
    for args in tuples:
        found = _unify_all(pattern.terms, args, bindings)
        if found is not None:
            yield found
