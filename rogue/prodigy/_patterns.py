"""Patterns of control rules, matched against goals, operators, their instances and nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rogue.prodigy._domain import Operator
from rogue.prodigy._events import NodeView
from rogue.prodigy._instance import Instance
from rogue.prodigy._terms import Literal, Term, Value, Variable

RuleValue = Value | Literal | Operator | Instance | NodeView
RuleBindings = Mapping[str, RuleValue]


@dataclass(frozen=True, slots=True)
class ListPattern:
    """``(name term ...)``: a literal, or an operator with its parameters."""

    name: str
    terms: tuple[Term, ...]
    positive: bool = True


@dataclass(frozen=True, slots=True)
class BindingsPattern:
    """``((<v> . term) ...)``: values of an operator's variables."""

    pairs: tuple[tuple[str, Term], ...]


@dataclass(frozen=True, slots=True)
class OneOf:
    """Any of several patterns, as in ``(current-ops (load unload))``."""

    patterns: tuple[Pattern, ...]


Pattern = Term | ListPattern | BindingsPattern | OneOf


def unify_all(pattern: Pattern, value: RuleValue, bindings: RuleBindings) -> Iterator[RuleBindings]:
    """Yield ``bindings`` extended in each way in which ``pattern`` is ``value``."""
    for one in pattern.patterns if isinstance(pattern, OneOf) else (pattern,):
        found = unify(one, value, bindings)
        if found is not None:
            yield found


def unify(pattern: Pattern, value: RuleValue, bindings: RuleBindings) -> RuleBindings | None:
    """Return ``bindings`` extended so that ``pattern`` is ``value``, or None."""
    match pattern:
        case Variable(name):
            if name not in bindings:
                return {**bindings, name: value}
            return bindings if plain(bindings[name]) == plain(value) else None
        case ListPattern(name, terms, positive):
            args = _args_of(value, name, positive=positive)
            return None if args is None else _unify_terms(terms, args, bindings)
        case BindingsPattern(pairs):
            return _unify_pairs(pairs, value, bindings)
        case OneOf():
            return next(unify_all(pattern, value, bindings), None)
    return bindings if pattern == _name(value) else None


def _args_of(value: RuleValue, name: str, *, positive: bool) -> tuple[Value, ...] | None:
    if isinstance(value, Literal):
        return value.args if (value.predicate, value.positive) == (name, positive) else None
    if isinstance(value, Instance) and value.name == name and positive:
        return value.args
    return None


def plain(value: RuleValue) -> object:
    """Return what two values of rules are compared by."""
    if isinstance(value, NodeView):
        return value.number
    return value.name if isinstance(value, Operator) else value


def _name(value: RuleValue) -> object:
    return value.name if isinstance(value, Instance) else plain(value)


def _unify_terms(
    terms: tuple[Term, ...], args: tuple[Value, ...], bindings: RuleBindings
) -> RuleBindings | None:
    if len(terms) != len(args):
        return None
    found: RuleBindings | None = bindings
    for term, value in zip(terms, args, strict=True):
        found = unify(term, value, found) if found is not None else None
    return found


def _unify_pairs(
    pairs: tuple[tuple[str, Term], ...], value: RuleValue, bindings: RuleBindings
) -> RuleBindings | None:
    if not isinstance(value, Instance):
        return None
    found: RuleBindings | None = bindings
    for name, term in pairs:
        if name not in value.bindings or found is None:
            return None
        found = unify(term, value.bindings[name], found)
    return found


def variables(pattern: Pattern) -> Iterator[str]:
    """Yield the names of the variables of a pattern, repeated where they repeat."""
    match pattern:
        case Variable(name):
            yield name
        case ListPattern(_, terms):
            yield from (term.name for term in terms if isinstance(term, Variable))
        case BindingsPattern(pairs):
            yield from (term.name for _, term in pairs if isinstance(term, Variable))
        case OneOf(patterns):
            for one in patterns:
                yield from variables(one)


def as_literal(pattern: Pattern, bindings: RuleBindings) -> ListPattern | None:
    """Return a literal's pattern with the values that its terms have now; None if it is none."""
    if isinstance(pattern, Variable):
        value = bindings.get(pattern.name)
        if isinstance(value, Literal):
            return ListPattern(value.predicate, value.args, value.positive)
        return None
    if not isinstance(pattern, ListPattern):
        return None
    terms = tuple(_term(term, bindings) for term in pattern.terms)
    return ListPattern(pattern.name, terms, pattern.positive)


def _term(term: Term, bindings: RuleBindings) -> Term:
    value = bindings.get(term.name, term) if isinstance(term, Variable) else term
    return value if isinstance(value, Value) else term


def resolved(pattern: Pattern, bindings: RuleBindings) -> object:
    """Return what a pattern means now: a value, a literal, or what of it is still unbound.

    A literal keeps a ``Variable`` in each place that has no value.
    """
    match pattern:
        case Variable(name):
            found = bindings.get(name, pattern)
            return found.name if isinstance(found, Operator) else found
        case ListPattern(name, terms, positive):
            args = tuple(_term(term, bindings) for term in terms)
            return Literal(name, args, positive)  # type: ignore[arg-type]
        case BindingsPattern(pairs):
            return {name: _term(term, bindings) for name, term in pairs}
        case OneOf(patterns):
            return tuple(resolved(one, bindings) for one in patterns)
    return pattern


def facts_matching(
    pattern: ListPattern, rows: Iterator[tuple[Value, ...]], bindings: RuleBindings
) -> Iterator[RuleBindings]:
    """Yield ``bindings`` extended by each of the arguments that the pattern fits."""
    for args in rows:
        found = _unify_terms(pattern.terms, args, bindings)
        if found is not None:
            yield found
