"""Which types the arguments of predicates can have, as the operators of a domain use them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rogue.prodigy._domain import Domain, Operator
from rogue.prodigy._expressions import Exists, Expression, Forall, Holds, Not, VariableSpec
from rogue.prodigy._terms import Atom, Term, Variable

Signatures = Mapping[str, tuple[frozenset[str] | None, ...]]
"""Types of the arguments of each predicate; None where any value may stand."""

_Scope = dict[str, VariableSpec]
_Members = frozenset[str] | None


def signatures(domain: Domain) -> Signatures:
    """Return, for predicates that change, the types of which operators or rules speak."""
    found: dict[str, tuple[_Members, ...]] = {}
    for operator in (*domain.operators, *domain.inference_rules):
        for atom, scope in _uses(operator):
            types = tuple(_members(term, scope, domain) for term in atom.terms)
            before = found.get(atom.predicate, types)
            found[atom.predicate] = tuple(map(_either, before, types))
    return {name: types for name, types in found.items() if not domain.is_static(name)}


def _either(one: _Members, other: _Members) -> _Members:
    return None if one is None or other is None else one | other


def _members(term: Term, scope: _Scope, domain: Domain) -> _Members:
    if isinstance(term, Variable):
        types = scope[term.name].types
        return None if domain.types.infinite_of(types) else domain.types.members(types)
    kind = domain.constants.get(term) if isinstance(term, str) else None
    return None if kind is None else frozenset([kind])


def _uses(operator: Operator) -> Iterator[tuple[Atom, _Scope]]:
    scope = {spec.name: spec for spec in operator.variables}
    yield from _atoms(operator.precondition, scope)
    for effect in operator.effects:
        inner = {**scope, **{spec.name: spec for spec in effect.variables}}
        yield effect.atom, inner
        yield from _atoms(effect.condition, inner)


def _atoms(expression: Expression, scope: _Scope) -> Iterator[tuple[Atom, _Scope]]:
    match expression:
        case Holds(atom):
            yield atom, scope
        case Not(part):
            yield from _atoms(part, scope)
        case Exists(specs, part) | Forall(specs, part):
            yield from _atoms(part, {**scope, **{spec.name: spec for spec in specs}})
        case _:
            for part in expression.parts:
                yield from _atoms(part, scope)
