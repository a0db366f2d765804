"""Expansion of nodes: the choices that the search makes."""

from __future__ import annotations

from dataclasses import dataclass

from rogue.prodigy._choose_applied import choose_applied
from rogue.prodigy._control import decide, filter_candidates, prefer_candidate
from rogue.prodigy._events import Choice, Decided, NodeKind, RuleFired
from rogue.prodigy._instance import Instance
from rogue.prodigy._instances import FINISH, instances_for, is_relevant
from rogue.prodigy._loops import looping_ancestor, looping_operator, repeats_state
from rogue.prodigy._nodes import Node
from rogue.prodigy._options import Mode
from rogue.prodigy._rules import Action, Candidate, RuleSet
from rogue.prodigy._running_view import RunningView
from rogue.prodigy._tail import Tail
from rogue.prodigy._terms import Literal
from rogue.prodigy._tree import Tree


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a node failed; ``structural`` if no other order of steps would change it."""

    node: Node
    reason: str
    structural: bool = False


@dataclass(frozen=True, slots=True)
class _Picked:
    chosen: Candidate
    left: tuple[Candidate, ...]
    fired: tuple[RuleFired, ...]
    reason: str


class Expander:
    """Makes the children of nodes; ``decisions`` collects what was decided and why."""

    def __init__(self, tree: Tree, rules: RuleSet, mode: Mode) -> None:
        self._tree = tree
        self._rules = rules
        self._mode = mode
        self.decisions: list[Decided] = []

    def expand(self, node: Node) -> Node | Failure | None:
        """Make a child of ``node``; None when an older node has nothing left to try."""
        match node.kind:
            case NodeKind.GOAL:
                return self._goal(node)
            case NodeKind.OPERATOR:
                return self._operator(node)
            case NodeKind.BINDING if node.failure == "" and not node.children:
                return self._check_binding(node) or self._choose(node)
        return self._choose(node)

    def _goal(self, node: Node) -> Node | Failure | None:
        assert node.goal is not None
        tree, goal, fired = self._tree, node.goal, tuple[RuleFired, ...]()
        if node.operators is None:
            world = tree.world(node.situation.state)
            operators = [o for o in tree.domain.operators if is_relevant(o, goal, world)]
            if not operators:
                return Failure(node, "no relevant operators", structural=True)
            view = self._view(node)
            filtered = filter_candidates(self._rules, Choice.OPERATOR, view, tuple(operators))
            node.operators = [c for c in operators if c in filtered.candidates]
            fired = filtered.fired
        if not node.operators:
            return Failure(node, "no choices for operators") if not node.children else None
        picked = self._pick(Choice.OPERATOR, node, tuple(node.operators), fired)
        operator = next(o for o in node.operators if o is picked.chosen)
        node.operators = [o for o in node.operators if o is not operator]
        child = tree.add_operator(node, operator)
        self._note(Choice.OPERATOR, node, child, picked)
        if not node.operators:
            tree.close(node)
        return child

    def _operator(self, node: Node) -> Node | Failure | None:
        fired: tuple[RuleFired, ...] = ()
        if node.instances is None:
            found = self._instances(node)
            if isinstance(found, Failure):
                return found
            node.instances, fired = found
        if not node.instances:
            return None
        picked = self._pick(Choice.BINDINGS, node, tuple(node.instances), fired)
        instance = next(i for i in node.instances if i is picked.chosen)
        node.instances = [i for i in node.instances if i is not instance]
        child = self._tree.add_binding(node, instance, len(node.instances))
        self._note(Choice.BINDINGS, node, child, picked)
        if not node.instances:
            self._tree.close(node)
        return child

    def _instances(self, node: Node) -> tuple[list[Instance], tuple[RuleFired, ...]] | Failure:
        assert node.operator is not None
        assert node.goal is not None
        assert node.goal_node is not None
        world = self._tree.world(node.situation.state)
        loop = looping_operator(node, world)
        if loop is not None:
            return Failure(node, f"goal loop with node {loop.number}", structural=True)
        made = list(instances_for(node.operator, node.goal, world))
        # The first three nodes are made by hand: no rule speaks of *finish*.
        rules = RuleSet() if node.operator.name == FINISH else self._rules
        filtered = filter_candidates(rules, Choice.BINDINGS, self._view(node), tuple(made))
        kept = {id(c) for c in filtered.candidates}
        instances = [i for i in made if id(i) in kept]
        if not instances:
            structural = not made and not any(v.calls for v in node.operator.variables)
            return Failure(node, "no choices for bindings (I tried)", structural)
        holds = world.state.holds
        instances.sort(key=lambda i: sum(not holds(p) for p in i.preconditions))
        return instances, filtered.fired

    def _check_binding(self, node: Node) -> Failure | None:
        situation = node.situation
        for literal in self._tree.needs(node):
            if situation.state.holds(literal):
                continue
            if (literal.predicate, literal.positive) not in self._tree.domain.changed:
                return Failure(node, "requires an unsolvable precondition", structural=True)
            ancestor = looping_ancestor(node, literal)
            if ancestor is not None:
                return Failure(node, f"goal loop with node {ancestor.number}", structural=True)
        return None

    def _choose(self, node: Node) -> Node | Failure | None:
        tail = Tail(node.situation, self._tree.needs)
        ready = [n for n in self._ready(tail) if n not in node.tried]
        pending = {} if node.only_apply else tail.pending()
        untried = tuple(goal for goal in pending if goal not in node.tried)
        view = self._view(node, tail)
        goals = filter_candidates(self._rules, Choice.GOAL, view, untried)
        operators = filter_candidates(
            self._rules, Choice.APPLIED_OP, view, tuple(n.instance for n in ready if n.instance)
        )
        kept = {id(c) for c in operators.candidates}
        ready = [n for n in ready if id(n.instance) in kept]
        if not ready and not goals.candidates:
            return None if node.children else Failure(node, "no pending goals")
        if self._is_subgoal(view, bool(ready), bool(goals.candidates)):
            return self._subgoal(node, pending, goals.candidates, goals.fired, len(ready))
        return self._apply(node, ready, view, operators.fired, len(goals.candidates))

    def _ready(self, tail: Tail) -> list[Node]:
        ready = tail.ready()
        if self._mode is Mode.SABA:
            return ready
        newest = next((n for n in tail.live() if n is not tail.finish), None)
        # Nothing to back-chain on and the newest blocked: it waits for an older one.
        return ready if not tail.pending() else [n for n in ready if n is newest]

    def _is_subgoal(self, view: RunningView, can_apply: bool, can_subgoal: bool) -> bool:
        if not (can_apply and can_subgoal):
            return can_subgoal
        ruled = decide(self._rules, view)
        if ruled is not None:
            return ruled[0] is Action.SUB_GOAL
        return self._mode is Mode.SABA

    def _subgoal(
        self,
        node: Node,
        pending: dict[Literal, list[Node]],
        goals: tuple[Candidate, ...],
        fired: tuple[RuleFired, ...],
        ready: int,
    ) -> Node:
        picked = self._pick(Choice.GOAL, node, goals, fired)
        goal = next(g for g in pending if g is picked.chosen)
        node.tried.add(goal)
        node.only_apply = self._mode is Mode.SABA
        others = 0 if node.only_apply else len(goals) - 1
        child = self._tree.add_goal(node, goal, pending[goal], others)
        self._note(Choice.GOAL, node, child, picked)
        if not others and not ready:
            self._tree.close(node)
        return child

    def _apply(
        self,
        node: Node,
        ready: list[Node],
        view: RunningView,
        fired: tuple[RuleFired, ...],
        goals: int,
    ) -> Node | Failure:
        binding, picked = self._pick_applied(ready, view, node, fired)
        node.tried.add(binding)
        child = self._tree.add_applied(node, binding)
        self._note(Choice.APPLIED_OP, node, child, picked)
        if len(ready) == 1 and not goals:
            self._tree.close(node)
        if repeats_state(child):
            return Failure(child, "applying leads to state loop")
        return child

    def _pick_applied(
        self, ready: list[Node], view: RunningView, node: Node, fired: tuple[RuleFired, ...]
    ) -> tuple[Node, _Picked]:
        candidates = tuple(n.instance for n in ready if n.instance)
        chosen, links = prefer_candidate(self._rules, Choice.APPLIED_OP, view, candidates)
        if chosen is None:
            world = self._tree.world(node.situation.state)
            binding, reason = choose_applied(ready, world)
        else:
            binding = next(n for n in ready if n.instance is chosen)
            reason = links[-1].rule
        if fired and len(ready) == 1:
            reason = fired[-1].rule
        assert binding.instance is not None
        return binding, _Picked(binding.instance, candidates, fired + links, reason)

    def _pick(
        self,
        choice: Choice,
        node: Node,
        candidates: tuple[Candidate, ...],
        fired: tuple[RuleFired, ...],
    ) -> _Picked:
        chosen, links = prefer_candidate(self._rules, choice, self._view(node), candidates)
        if chosen is not None:
            return _Picked(chosen, candidates, fired + links, links[-1].rule)
        default = "only one" if len(candidates) == 1 else "first"
        reason = fired[-1].rule if fired else default
        return _Picked(candidates[0], candidates, fired, reason)

    def _view(self, node: Node, tail: Tail | None = None) -> RunningView:
        tail = tail or Tail(node.situation, self._tree.needs)
        return RunningView(node, tail, self._tree.objects)

    def _note(self, choice: Choice, node: Node, child: Node, picked: _Picked) -> None:
        removed = [e for f in picked.fired if f.action == "reject" for e in f.effect]
        alternatives = (*map(str, picked.left), *removed)
        child.decided_by = picked.reason
        self.decisions.append(
            Decided(
                choice,
                node.number,
                child.view(),
                str(picked.chosen),
                alternatives,
                picked.reason,
                picked.fired,
            )
        )
