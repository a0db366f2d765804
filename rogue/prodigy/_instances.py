"""Instantiation of operators: for a goal, or in every way."""

from __future__ import annotations

from collections.abc import Iterator

from rogue.prodigy._domain import Effect, Operator
from rogue.prodigy._effects import achieves
from rogue.prodigy._expressions import TRUE, And, Expression, Holds, VariableSpec
from rogue.prodigy._functions import GEN_FROM_PRED
from rogue.prodigy._grounding import World
from rogue.prodigy._instance import Instance
from rogue.prodigy._terms import Atom, Bindings, Literal, Value, Variable


def is_relevant(operator: Operator, goal: Literal, world: World) -> bool:
    """Say whether an effect of ``operator`` unifies with ``goal``, types included."""
    return any(True for _ in _unified(operator, goal, world))


def instances_for(operator: Operator, goal: Literal, world: World) -> Iterator[Instance]:
    """Yield the instances of ``operator`` that make ``goal`` true, each once.

    Static preconditions and the functions of the variables' types filter them. The condition of
    a conditional effect becomes part of the preconditions.
    """
    seen: set[tuple[object, ...]] = set()
    for effect, bound in _unified(operator, goal, world):
        specs = operator.variables + effect.variables
        condition = And((operator.precondition, effect.condition))
        for bindings in _completed(specs, bound, _static_atoms(condition, world), world):
            for literals in world.branches(condition, bindings):
                instance = Instance(operator, bindings, literals, goal)
                key = (tuple(sorted(bindings.items())), literals)
                if key not in seen and _possible(literals, world):
                    seen.add(key)
                    if achieves(instance, goal, world):
                        yield instance


def all_instances(operator: Operator, world: World) -> Iterator[Instance]:
    """Yield every instance of ``operator`` whose static preconditions hold."""
    static = _static_atoms(operator.precondition, world)
    for bindings in _completed(operator.variables, {}, static, world):
        for literals in world.branches(operator.precondition, bindings):
            if _possible(literals, world):
                yield Instance(operator, bindings, literals)


def regressed(operator: Operator, goal: Literal, world: World) -> Iterator[tuple[Literal, ...]]:
    """Yield, per unifying effect, the plain preconditions that the goal alone makes ground."""
    for _, bound in _unified(operator, goal, world):
        plain = _plain_atoms(operator.precondition)
        yield tuple(a.ground(bound) for a in plain if all(v in bound for v in a.variables()))


def _unified(
    operator: Operator, goal: Literal, world: World
) -> Iterator[tuple[Effect, dict[str, Value]]]:
    types = {spec.name: spec for spec in operator.variables}
    for effect in operator.effects:
        if effect.adds != goal.positive or effect.atom.predicate != goal.predicate:
            continue
        bound = effect.atom.match(goal.args, {})
        local = {spec.name: spec for spec in effect.variables}
        known = {**types, **local}
        if bound is not None and all(world.fits(v, known[name]) for name, v in bound.items()):
            yield effect, bound


def _completed(
    specs: tuple[VariableSpec, ...], bindings: Bindings, static: tuple[Atom, ...], world: World
) -> Iterator[dict[str, Value]]:
    for atom in static:
        ground = all(name in bindings for name in atom.variables())
        if ground and not world.state.holds(atom.ground(bindings)):
            return
    free = [spec for spec in specs if spec.name not in bindings]
    if not free:
        if all(world.passes(call, bindings) for spec in specs for call in spec.calls):
            yield dict(bindings)
        return
    spec = _next_variable(free, bindings)
    for value in _narrowed(spec, bindings, static, world):
        yield from _completed(specs, {**bindings, spec.name: value}, static, world)


def _next_variable(free: list[VariableSpec], bindings: Bindings) -> VariableSpec:
    def is_ready(spec: VariableSpec) -> bool:
        return all(
            not isinstance(term, Variable) or term.name in bindings or term.name == spec.name
            for call in spec.calls
            for term in (call.pattern.terms if call.pattern else call.terms)
        )

    return next((spec for spec in free if is_ready(spec)), free[0])


def _narrowed(
    spec: VariableSpec, bindings: Bindings, static: tuple[Atom, ...], world: World
) -> Iterator[Value]:
    for atom in static:
        generated = any(call.function == GEN_FROM_PRED for call in spec.calls)
        if spec.name in atom.variables() and not generated:
            found = {m[spec.name] for m in world.matches(atom, bindings)}
            for value in world.in_order(v for v in found if world.fits(v, spec)):
                extended = {**bindings, spec.name: value}
                if all(world.passes(call, extended) for call in spec.calls):
                    yield value
            return
    yield from world.values(spec, bindings)


def _plain_atoms(expression: Expression) -> Iterator[Atom]:
    match expression:
        case Holds(atom):
            yield atom
        case And(parts):
            for part in parts:
                yield from _plain_atoms(part)


def _static_atoms(expression: Expression, world: World) -> tuple[Atom, ...]:
    return tuple(a for a in _plain_atoms(expression) if world.domain.is_static(a.predicate))


def _possible(literals: tuple[Literal, ...], world: World) -> bool:
    return all(
        world.state.holds(literal) or not world.domain.is_static(literal.predicate)
        for literal in literals
    )


FINISH = "*finish*"
DONE = Literal("done")


def finish_operator(variables: tuple[VariableSpec, ...], goal: Expression) -> Operator:
    """Return the pseudo-operator whose precondition is the goal of a problem."""
    return Operator(FINISH, (), variables, goal, (Effect(Atom("done"), True, (), TRUE),))
