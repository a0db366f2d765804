"""What follows from the facts by inference rules.

Static rules fire at the root until nothing new follows; what they say stays. Eager rules fire
after every change once: they see what others inferred before, not what they infer at the same
time. Lazy rules are chosen like operators; what they said stays while it follows. Whatever no
longer follows from what is left, in any way, is retracted.

A lazy rule's conclusion is false until the rule is chosen, so nothing may depend on its being
false: predicates that occur in a negation, a quantifier, or the condition of an effect are
worked out in full instead. All of this is a function of the facts that operators made and of what
was inferred before, so backtracking and corrections by executed outcomes need no bookkeeping.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from rogue.prodigy._domain import Domain, InferenceMode, InferenceRule
from rogue.prodigy._expressions import Expression, required
from rogue.prodigy._grounding import World
from rogue.prodigy._state import State
from rogue.prodigy._strata import consulted, in_strata, mentioned
from rogue.prodigy._terms import Literal

Literals = frozenset[Literal]
_NONE: Literals = frozenset()


@dataclass(frozen=True, slots=True)
class Inferred:
    """A state with what was inferred in it.

    Attributes:
        base: The facts that operators and static rules made.
        state: All that is true.
        eager: What eager rules inferred.
        lazy: What lazy rules that were chosen inferred, as far as it still follows.
    """

    base: State
    state: State
    eager: Literals = _NONE
    lazy: Literals = _NONE


class Inference:
    """The inference rules of a domain at work.

    Args:
        domain: Its rules are used.
        goals: Goals of the problem, of which negations count as in the domain.

    Raises:
        InferenceError: If what a rule infers hangs on its not being inferred.
    """

    def __init__(self, domain: Domain, goals: Iterable[Expression] = ()) -> None:
        rules = domain.inference_rules
        self._static = in_strata([r for r in rules if r.mode is InferenceMode.STATIC])
        eager = [r for r in rules if r.mode is InferenceMode.EAGER]
        lazy = [r for r in rules if r.mode is InferenceMode.LAZY]
        self._eager, self._lazy = in_strata(eager), in_strata(lazy)
        heads = {e.atom.predicate for rule in eager for e in rule.effects}
        self._is_chained = any(heads & mentioned(rule) for rule in eager)
        full = _needed_in_full(lazy, consulted(domain, goals))
        self._full = in_strata([r for r in lazy if r in full])
        self.lazy_rules = tuple(r for r in lazy if r not in full)
        self.is_idle = not rules

    def rooted(self, world: World) -> State:
        """Return a state with what static rules say in it."""
        return self._closed(world, self._static)[0] if self._static else world.state

    def start(self, world: World) -> Inferred:
        """Return what is so at a root with the facts of ``world``."""
        rooted = self.rooted(world)
        return self.after(Inferred(rooted, rooted), world.at(rooted))

    def after(self, before: Inferred, world: World) -> Inferred:
        """Return what is so once operators or others have made ``world`` of what was so.

        Args:
            before: What was so.
            world: What operators and static rules made, without what else is inferred.
        """
        base = world.state
        if self.is_idle:
            return Inferred(base, base)
        eager = self._eager_round(before.eager, world) if self._eager else _NONE
        return self._lazily(world, eager, before.lazy)

    def fired(self, before: Inferred, said: Literals, world: World) -> Inferred:
        """Return what is so once a lazy rule was fired that says ``said``."""
        return self._lazily(world.at(before.base), before.eager, before.lazy | said)

    def axioms(self, before: Inferred, world: World) -> Inferred:
        """Return what ``after`` does, as if all lazy rules were chosen wherever they can fire."""
        base = world.state
        if self.is_idle:
            return Inferred(base, base)
        eager = self._eager_round(before.eager, world)
        state, lazy = self._closed(world.at(_with(base, eager)), self._lazy)
        return Inferred(base, state, eager, lazy)

    def _lazily(self, world: World, eager: Literals, lazy: Literals) -> Inferred:
        base, state = world.state, _with(world.state, eager)
        if self._full:
            state, _ = self._closed(world.at(state), self._full)
        if lazy:
            state, lazy = self._closed(world.at(state), self._lazy, only=lazy)
        return Inferred(base, state, eager, lazy)

    def _eager_round(self, before: Literals, world: World) -> Literals:
        kept = _NONE
        if before and self._is_chained:
            state, kept = self._closed(world, self._eager, only=before)
            world = world.at(state)
        said = {one for stratum in self._eager for rule in stratum for one in _says(rule, world)}
        return kept | said

    def _closed(
        self,
        world: World,
        strata: Sequence[Sequence[InferenceRule]],
        *,
        only: Literals | None = None,
    ) -> tuple[State, Literals]:
        """Return the state with all that follows, of ``only`` if given, and what that is."""
        base, state, found = world.state, world.state, set[Literal]()
        for stratum in strata:
            while True:
                said = {one for rule in stratum for one in _says(rule, world.at(state))}
                new = (said if only is None else said & only) - found
                if not new:
                    break
                found |= new
                state = _with(base, found)
        return state, frozenset(found)


def _says(rule: InferenceRule, world: World) -> Iterator[Literal]:
    """Yield what a rule says in a state, each where its condition holds."""
    condition = rule.precondition
    for bindings in world.combinations(rule.variables, {}, required(condition)):
        if not world.holds(condition, bindings):
            continue
        for effect in rule.effects:
            for case in world.combinations(effect.variables, bindings):
                if world.holds(effect.condition, case):
                    yield effect.atom.ground(case, positive=effect.adds)


def _with(base: State, said: Iterable[Literal]) -> State:
    said = tuple(said)
    if not said:
        return base
    added = [one for one in said if one.positive]
    return base.changed(added, [one.negated() for one in said if not one.positive])


def _needed_in_full(rules: list[InferenceRule], names: set[str]) -> set[InferenceRule]:
    """Return the rules that infer a predicate of ``names``, and those on which they rest."""
    full: set[InferenceRule] = set()
    while True:
        more = {r for r in rules if r not in full and {e.atom.predicate for e in r.effects} & names}
        if not more:
            return full
        full |= more
        names = names | {name for rule in more for name in mentioned(rule)}
