"""The choice at binding and applied nodes: sub-goal or apply, which goal, which operator."""

from __future__ import annotations

from collections.abc import Iterable

from rogue.prodigy._choose_applied import choose_applied
from rogue.prodigy._control import Filtered, decide
from rogue.prodigy._decide import Decider, Failure, Picked
from rogue.prodigy._events import Choice
from rogue.prodigy._instance import Instance
from rogue.prodigy._levels import AbstractionLevels
from rogue.prodigy._nodes import Node
from rogue.prodigy._options import Mode, SearchOptions
from rogue.prodigy._protect import protections
from rogue.prodigy._rules import Action, DecideRule
from rogue.prodigy._terms import Literal
from rogue.prodigy._tree import Tree

Pending = dict[Literal, tuple[Node, ...]]


class Chooser:
    """Makes the children of binding and applied nodes."""

    def __init__(self, tree: Tree, decider: Decider, options: SearchOptions) -> None:
        self._tree = tree
        self._decider = decider
        self._mode = options.mode
        self._levels = AbstractionLevels(tree.domain) if options.use_abs_level else None
        decisions = [r for r in decider.rules.rules if isinstance(r, DecideRule)]
        self._has_decide_rules = bool(decisions)
        self._has_protect_rules = any(r.action is Action.PROTECT for r in decisions)
        self._protects = options.protection or self._has_protect_rules

    def choose(self, node: Node) -> Node | Failure | None:
        """Make a child of ``node``; None when an older node has nothing left to try."""
        node.is_unsettled = False
        pending = self._pending(node)
        goals = self._goals(node, pending)
        if goals.candidates and self._mode is Mode.SABA and not self._has_decide_rules:
            # Whether an operator could be applied instead is looked at when it matters.
            node.is_unsettled = True
            return self._subgoal(node, pending, goals, can_apply=True)
        ready, operators = self._applicable(node)
        if not ready and not goals.candidates:
            reason = goals.explained(operators.explained("no pending goals"))
            child = self._protect(node) if self._protects else None
            return child or (None if node.children else Failure(node, reason))
        can_apply, can_subgoal = bool(ready), bool(goals.candidates)
        ruled = self._ruled(node, can_apply=can_apply, can_subgoal=can_subgoal)
        if ruled is Action.PROTECT and (child := self._protect(node)) is not None:
            return child
        if self._is_subgoal(ruled, can_apply=can_apply, can_subgoal=can_subgoal):
            return self._subgoal(node, pending, goals, can_apply=can_apply)
        return self._apply(node, ready, operators, can_subgoal=can_subgoal)

    def is_spent(self, node: Node) -> bool:
        """Say whether a node at which something may be left to try has nothing left."""
        if (
            self._protects
            or not node.is_unsettled
            or self._goals(node, self._pending(node)).candidates
        ):
            return False
        return not self._applicable(node)[0]

    def _pending(self, node: Node) -> Pending:
        if node.only_apply:
            return {}
        pending = node.situation.view.pending()
        if self._levels is not None:
            in_order = self._levels.sorted(pending)
            pending = {goal: pending[goal] for goal in in_order}
        return pending

    def _goals(self, node: Node, pending: Pending) -> Filtered:
        untried = tuple(goal for goal in pending if goal not in node.tried)
        return self._decider.filter(Choice.GOAL, node, untried)

    def _applicable(self, node: Node) -> tuple[list[Node], Filtered]:
        ready = [n for n in self._ready(node) if n not in node.tried]
        found = self._decider.filter(Choice.APPLIED_OP, node, _instances(ready))
        kept = {id(c) for c in found.candidates}
        return [n for n in ready if id(n.instance) in kept], found

    def _ready(self, node: Node) -> list[Node]:
        tail = node.situation.view
        ready = tail.ready()
        # Nothing to back-chain on and the newest blocked: it waits for an older one.
        if self._mode is Mode.SABA or not ready or not tail.pending():
            return ready
        return [n for n in ready if n is tail.newest]

    def _ruled(self, node: Node, *, can_apply: bool, can_subgoal: bool) -> Action | None:
        """Return what a rule says to do here, None if none speaks."""
        if not can_apply or not (can_subgoal or self._has_protect_rules):
            return None
        ruled = decide(self._decider.rules, self._decider.view(node))
        if ruled is None or not (can_subgoal or ruled[0] is Action.PROTECT):
            return None
        self._decider.note_decided(node, *ruled)
        return ruled[0]

    def _is_subgoal(self, ruled: Action | None, *, can_apply: bool, can_subgoal: bool) -> bool:
        if not (can_apply and can_subgoal):
            return can_subgoal
        if ruled in {Action.SUB_GOAL, Action.APPLY}:
            return ruled is Action.SUB_GOAL
        return self._mode is Mode.SABA

    def _subgoal(self, node: Node, pending: Pending, goals: Filtered, *, can_apply: bool) -> Node:
        picked = self._decider.pick(Choice.GOAL, node, goals)
        goal = next(g for g in pending if g is picked.chosen)
        node.tried.add(goal)
        node.only_apply = self._mode is Mode.SABA
        others = 0 if node.only_apply else len(goals.candidates) - 1
        child = self._tree.add_goal(node, goal, pending[goal], others)
        self._decider.note(Choice.GOAL, node, child, picked)
        if not (others or can_apply or self._protects):
            self._tree.close(node)
        return child

    def _apply(
        self, node: Node, ready: list[Node], operators: Filtered, *, can_subgoal: bool
    ) -> Node | Failure:
        binding, picked = self._pick_applied(node, ready, operators)
        node.tried.add(binding)
        child = self._tree.add_applied(node, binding)
        self._decider.note(Choice.APPLIED_OP, node, child, picked)
        if len(ready) == 1 and not (can_subgoal or self._protects):
            self._tree.close(node)
        if child.situation.repeats(node.situation):
            return Failure(child, "applying leads to state loop")
        return child

    def _protect(self, node: Node) -> Node | None:
        world = self._tree.world(node.situation.state)
        untried = [p for p in protections(node.situation, world) if p not in node.tried]
        if not untried:
            return None
        node.tried.add(untried[0])
        child = self._tree.add_protection(node, untried[0])
        texts = tuple(map(str, untried))
        self._decider.note_protection(node, child, texts)
        return child

    def _pick_applied(
        self, node: Node, ready: list[Node], operators: Filtered
    ) -> tuple[Node, Picked]:
        candidates, fired = _instances(ready), operators.fired
        chosen, links = self._decider.prefer(Choice.APPLIED_OP, node, Filtered(candidates, fired))
        if chosen is None:
            world = self._tree.world(node.situation.state)
            binding, reason = choose_applied(ready, world)
        else:
            binding = next(n for n in ready if n.instance is chosen)
            reason = links[-1].rule
        if fired and len(ready) == 1:
            reason = fired[-1].rule
        assert binding.instance is not None
        return binding, Picked(binding.instance, candidates, fired + links, reason)


def _instances(nodes: Iterable[Node]) -> tuple[Instance, ...]:
    return tuple(n.instance for n in nodes if n.instance is not None)
