"""Instantiation of operators: for a goal, or in every way."""

from __future__ import annotations

from collections.abc import Iterator

from rogue.prodigy._domain import Effect, Operator
from rogue.prodigy._effects import achieves
from rogue.prodigy._expressions import TRUE, And, Expression, Holds, VariableSpec, required
from rogue.prodigy._grounding import World
from rogue.prodigy._instance import Instance
from rogue.prodigy._terms import Atom, Literal, Value


def is_relevant(operator: Operator, goal: Literal, world: World) -> bool:
    """Say whether an effect of ``operator`` unifies with ``goal``, types included."""
    return any(True for _ in _unified(operator, goal, world))


def instances_for(operator: Operator, goal: Literal, world: World) -> Iterator[Instance]:
    """Yield the instances of ``operator`` that make ``goal`` true, each once.

    Static preconditions and the functions of the variables' types filter them. The condition of
    a conditional effect becomes part of the preconditions. Variables of the effects range over
    all objects when the instance is applied, whatever the goal says of them, unless they are
    parameters or of infinite type.
    """
    seen: set[tuple[object, ...]] = set()
    for effect, bound in _unified(operator, goal, world):
        specs = operator.variables + effect.variables
        condition = And((operator.precondition, effect.condition))
        given, hints = world.static(condition), required(condition)
        ranging = _ranging(operator, effect, world)
        for bindings in world.combinations(specs, bound, given, hints):
            for literals in world.branches(condition, bindings):
                own = {name: v for name, v in bindings.items() if name not in ranging}
                instance = Instance(operator, own, literals, goal)
                key = (tuple(sorted(own.items())), literals)
                if key not in seen and _possible(literals, world):
                    seen.add(key)
                    if achieves(instance, goal, world):
                        yield instance


def _ranging(operator: Operator, effect: Effect, world: World) -> frozenset[str]:
    infinite_of = world.domain.types.infinite_of
    mine = (spec for spec in effect.variables if not infinite_of(spec.types))
    return frozenset(spec.name for spec in mine).difference(operator.params)


def all_instances(operator: Operator, world: World) -> Iterator[Instance]:
    """Yield every instance of ``operator`` whose static preconditions hold."""
    given, hints = world.static(operator.precondition), required(operator.precondition)
    for bindings in world.combinations(operator.variables, {}, given, hints):
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


def _plain_atoms(expression: Expression) -> Iterator[Atom]:
    match expression:
        case Holds(atom):
            yield atom
        case And(parts):
            for part in parts:
                yield from _plain_atoms(part)


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
