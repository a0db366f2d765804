"""Whether all instances of an operator can be listed, and whether they change with the state."""

from __future__ import annotations

from rogue.prodigy._domain import Domain, Operator
from rogue.prodigy._expressions import And, Call, Requirement, VariableSpec, required
from rogue.prodigy._functions import Generator


def is_enumerable(operator: Operator, domain: Domain) -> bool:
    """Say whether every instance can be listed from the state alone.

    It cannot where only a goal gives the value of a variable of infinite type.
    """
    if not _all_known(operator.variables, required(operator.precondition), domain):
        return False
    return all(
        _all_known(
            operator.variables + effect.variables,
            required(And((operator.precondition, effect.condition))),
            domain,
        )
        for effect in operator.effects
        if effect.adds
    )


def varies(operator: Operator, domain: Domain) -> bool:
    """Say whether the instances depend on facts that change."""
    patterns = (call.pattern for spec in operator.variables for call in spec.calls)
    return any(p is not None for p in patterns) or not _all_known(operator.variables, (), domain)


def _all_known(
    specs: tuple[VariableSpec, ...], needs: tuple[Requirement, ...], domain: Domain
) -> bool:
    in_facts = {name for r in needs if r.positive for name in r.variables}
    known = {spec.name for spec in specs if not domain.types.infinite_of(spec.types)}
    known |= in_facts | {s.name for s in specs for c in s.calls if c.pattern is not None}
    missing = [spec for spec in specs if spec.name not in known]
    while found := [spec for spec in missing if _follows(spec, known, domain)]:
        known.update(spec.name for spec in found)
        missing = [spec for spec in missing if spec not in found]
    return not missing


def _follows(spec: VariableSpec, known: set[str], domain: Domain) -> bool:
    calls = _generators(spec, domain)
    return any(set(call.variables()) <= known | {spec.name} for call in calls)


def _generators(spec: VariableSpec, domain: Domain) -> list[Call]:
    functions = domain.functions
    return [c for c in spec.calls if isinstance(functions.get(c.function), Generator)]
