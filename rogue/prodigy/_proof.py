"""Proofs that there is no plan."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from rogue.prodigy._budget import Budget
from rogue.prodigy._domain import InferenceMode, Operator
from rogue.prodigy._effects import changes
from rogue.prodigy._enumerable import is_enumerable, varies
from rogue.prodigy._errors import TooManyValuesError
from rogue.prodigy._grounding import World
from rogue.prodigy._inference import Inference, Inferred
from rogue.prodigy._instance import Instance
from rogue.prodigy._instances import all_instances
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal

MOST_GROUNDED = 150_000
"""Values and literals of instances that are looked at before the proof is given up."""
CHECKS_A_STATE = 50
"""Instances checked per state of the budget, on average."""

LEAST_VALUES = 200_000
"""Values that may be tried for a proof however few states are to be looked at."""

Goals = tuple[Literal, ...]


@dataclass(frozen=True, slots=True)
class Proof:
    """Whether it is proved that there is no plan.

    Attributes:
        is_proved: True only if there is none.
        reason: How it was proved, or why not.
        hopeless: Goals that cannot be reached each by itself.
    """

    is_proved: bool
    reason: str
    hopeless: Goals = ()


class _OutOfBudgetError(Exception):
    """Too much to look at."""


def proof_budget(states: int, is_late: Callable[[], bool]) -> Budget:
    """Return the budget of a proof that may look at ``states`` states."""
    return Budget(max(LEAST_VALUES, states * CHECKS_A_STATE), is_late)


def prove_unsolvable(
    world: World,
    alternatives: Iterable[Goals],
    states: int,
    inference: Inference,
    inferred: Inferred,
) -> Proof:
    """Try to prove that no plan reaches any of the alternative sets of goals.

    First with deletions and additions ignored as obstacles, which is quick and can name the
    goals to blame; then by looking at every state that can be reached, up to ``states``.

    Args:
        world: What is so without inference.
        alternatives: The sets of goals.
        states: How many states may be looked at.
        inference: The inference rules.
        inferred: What was inferred so far, from which the rest follows.

    Raises:
        OutOfTimeError: If the time of the budget of ``world`` is up.
    """
    domain = world.domain
    if not all(is_enumerable(o, domain) for o in (*domain.operators, *domain.inference_rules)):
        return Proof(False, "whether there is a plan is not known")
    try:
        goal_sets = list(alternatives)
    except TooManyValuesError:
        return Proof(False, "whether there is a plan is not known")
    if not goal_sets:
        return Proof(True, "no values for the variables of the goal")
    try:
        missed = _relaxed(world, goal_sets, inference.axioms(inferred, world))
    except (_OutOfBudgetError, TooManyValuesError):
        missed = []
    if missed and all(missed):
        hopeless = tuple(dict.fromkeys(goal for goals in missed for goal in goals))
        named = ", ".join(map(str, hopeless))
        return Proof(True, f"proved unsolvable: nothing can bring about {named}", hopeless)
    if not states:
        return Proof(False, "whether there is a plan is not known")
    return _exhaustive(world, goal_sets, states, inference, inferred)


def _relaxed(world: World, goal_sets: list[Goals], begun: Inferred) -> list[Goals]:
    """Return, for each set of goals, those that stay out of reach even without obstacles.

    What is inferred may come to be so like what operators do, and may always end.
    """
    start, reached, undone = begun.state, begun.state, set[Literal]()
    domain = world.domain
    rules = [r for r in domain.inference_rules if r.mode is not InferenceMode.STATIC]
    inferred = {effect.atom.predicate for rule in rules for effect in rule.effects}

    def is_reachable(literal: Literal) -> bool:
        if not literal.positive and literal.predicate in inferred:
            return True
        return _reachable(literal, start, reached, undone)

    size = -1
    while size != (size := sum(1 for _ in reached.facts()) + len(undone)):
        now = world.at(reached)
        for instance in _ground([*domain.operators, *rules], now):
            if all(is_reachable(p) for p in instance.preconditions):
                added, deleted = _possible_effects(instance, now)
                reached = reached.changed(added)
                undone.update(deleted)
    return [tuple(g for g in goals if not is_reachable(g)) for goals in goal_sets]


def _reachable(literal: Literal, start: State, reached: State, undone: set[Literal]) -> bool:
    if literal.positive:
        return reached.holds(literal)
    return start.holds(literal) or literal.negated() in undone


def _possible_effects(instance: Instance, world: World) -> tuple[list[Literal], list[Literal]]:
    added: list[Literal] = []
    deleted: list[Literal] = []
    for effect in instance.operator.effects:
        for case in world.combinations(effect.variables, instance.bindings):
            (added if effect.adds else deleted).append(effect.atom.ground(case))
    return added, deleted


def _ground(operators: Iterable[Operator], world: World) -> Iterator[Instance]:
    made = 0
    for operator in operators:
        for instance in all_instances(operator, world):
            made += 1 + len(instance.bindings) + len(instance.preconditions)
            if made > MOST_GROUNDED:
                raise _OutOfBudgetError
            yield instance


def _exhaustive(
    world: World,
    goal_sets: list[Goals],
    states: int,
    inference: Inference,
    inferred: Inferred,
) -> Proof:
    operators = world.domain.operators
    try:
        fixed = list(_ground([o for o in operators if not varies(o, world.domain)], world))
        varying = [o for o in operators if varies(o, world.domain)]
        start = inference.axioms(inferred, world)
        seen = {(start.base, start.eager)}
        agenda, checks = deque([start]), 0
        while agenda:
            facts = agenda.popleft()
            now = world.at(facts.state)
            if now.budget is not None:
                now.budget.spend()
            if any(all(map(now.state.holds, goals)) for goals in goal_sets):
                return Proof(False, "there is a plan")
            instances = [*fixed, *_ground(varying, now)]
            checks += len(instances)
            for base in _successors(now, facts.base, instances):
                after = inference.axioms(facts, world.at(base))
                if (after.base, after.eager) not in seen:
                    seen.add((after.base, after.eager))
                    agenda.append(after)
            if len(seen) > states or checks > states * CHECKS_A_STATE:
                return Proof(False, "whether there is a plan is not known")
    except (_OutOfBudgetError, TooManyValuesError):
        return Proof(False, "whether there is a plan is not known")
    return Proof(True, f"proved unsolvable: none of the {len(seen)} states in reach has the goals")


def _successors(world: World, base: State, instances: Iterable[Instance]) -> Iterator[State]:
    for instance in instances:
        if all(map(world.state.holds, instance.preconditions)):
            made = changes(instance, world, base)
            yield base.changed(made.added, made.deleted)
