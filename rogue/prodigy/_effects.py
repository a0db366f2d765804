"""What an instantiated operator changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rogue.prodigy._domain import Effect
from rogue.prodigy._expressions import TRUE, required
from rogue.prodigy._grounding import World
from rogue.prodigy._instance import Instance
from rogue.prodigy._state import State
from rogue.prodigy._terms import Bindings, Literal, Value


@dataclass(frozen=True, slots=True)
class Changes:
    """What becomes true and what becomes false; both as positive literals, disjoint."""

    added: tuple[Literal, ...] = ()
    deleted: tuple[Literal, ...] = ()


def changes(instance: Instance, world: World, base: State) -> Changes:
    """Return the facts whose truth changes when ``instance`` is applied.

    Conditions are those of ``world``; ``base`` is what is so without inference.
    """
    adds, deletes = gross_changes(instance, world)
    holds = base.holds
    return Changes(
        tuple(fact for fact in adds if not holds(fact)),
        tuple(fact for fact in deletes if fact not in adds),
    )


def gross_changes(
    instance: Instance, world: World
) -> tuple[dict[Literal, None], dict[Literal, None]]:
    """Return everything added, true before or not, and every true fact deleted, in order."""
    adds: dict[Literal, None] = {}
    deletes: dict[Literal, None] = {}
    for effect in instance.operator.effects:
        if effect.adds:
            adds.update(dict.fromkeys(_added(effect, instance.bindings, world)))
        else:
            deletes.update(dict.fromkeys(_deleted(effect, instance.bindings, world)))
    return adds, deletes


def says(instance: Instance, world: World) -> Iterator[Literal]:
    """Yield what an instance of an inference rule says under any further condition."""
    for effect in instance.operator.effects:
        if effect.condition == TRUE:
            for case in world.combinations(effect.variables, instance.bindings):
                yield effect.atom.ground(case, positive=effect.adds)


def makes(instance: Instance, literal: Literal, world: World) -> bool:
    """Say whether applying ``instance`` now makes ``literal`` true, were it false."""
    if not _touches(instance, literal, world, adds=literal.positive):
        return False
    return literal.positive or not _touches(instance, literal, world, adds=True)


def achieves(instance: Instance, goal: Literal, world: World) -> bool:
    """Say whether no other unconditional effect of ``instance`` undoes ``goal``."""
    if goal.positive:
        return True
    unconditional = [e for e in instance.operator.effects if e.adds and e.condition == TRUE]
    return not any(_covers(e, goal, instance.bindings, world) for e in unconditional)


def _touches(instance: Instance, literal: Literal, world: World, *, adds: bool) -> bool:
    for effect in instance.operator.effects:
        if effect.adds == adds and effect.atom.predicate == literal.predicate:
            bound = effect.atom.match(literal.args, instance.bindings)
            if bound is not None and _applies(effect, bound, world):
                return True
    return False


def _covers(effect: Effect, literal: Literal, bindings: Bindings, world: World) -> bool:
    if effect.atom.predicate != literal.predicate:
        return False
    bound = effect.atom.match(literal.args, bindings)
    return bound is not None and _fits(effect, bound, world)


def _applies(effect: Effect, bound: dict[str, Value], world: World) -> bool:
    if not _fits(effect, bound, world):
        return False
    if effect.condition == TRUE:
        return True
    cases = world.combinations(effect.variables, bound, required(effect.condition))
    return any(world.holds(effect.condition, case) for case in cases)


def _fits(effect: Effect, bound: dict[str, Value], world: World) -> bool:
    named = [spec for spec in effect.variables if spec.name in bound]
    return all(
        world.fits(bound[spec.name], spec) and all(world.passes(c, spec, bound) for c in spec.calls)
        for spec in named
    )


def _added(effect: Effect, bindings: Bindings, world: World) -> Iterator[Literal]:
    for case in world.combinations(effect.variables, bindings, required(effect.condition)):
        if world.holds(effect.condition, case):
            yield effect.atom.ground(case)


def _deleted(effect: Effect, bindings: Bindings, world: World) -> Iterator[Literal]:
    # Only what is true can be deleted: matching the facts spares a walk over all objects.
    for bound in list(world.matches(effect.atom, bindings)):
        if _applies(effect, bound, world):
            yield effect.atom.ground(bound)
