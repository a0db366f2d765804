"""Expansion of nodes: which node, which operator for a goal, which bindings for an operator."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rogue.prodigy._choose import Chooser
from rogue.prodigy._control import Filtered, filter_candidates
from rogue.prodigy._decide import Decider, Failure
from rogue.prodigy._domain import InferenceMode, Operator
from rogue.prodigy._errors import TooManyValuesError
from rogue.prodigy._events import Choice, Decided, NodeKind, NodeView
from rogue.prodigy._instance import Instance
from rogue.prodigy._instances import FINISH, instances_for, is_relevant
from rogue.prodigy._loops import looping_ancestor, looping_operator
from rogue.prodigy._nodes import Node
from rogue.prodigy._options import SearchOptions
from rogue.prodigy._result import Limit, LimitKind
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._terms import Literal
from rogue.prodigy._tree import Tree

__all__ = ["Expander", "Failure"]


class Expander:
    """Makes the children of nodes."""

    def __init__(self, tree: Tree, rules: RuleSet, options: SearchOptions) -> None:
        self._tree = tree
        self._options = options
        self._decider = Decider(tree, rules)
        self._chooser = Chooser(tree, self._decider, options)
        self._has_node_rules = self._decider.has_rules(Choice.NODE)
        inferring = tree.domain.inference_rules
        lazy = [r for r in inferring if r.mode is InferenceMode.LAZY]
        self._achievers = _by_effect([*tree.domain.operators, *lazy])
        self._eager = _by_effect([r for r in inferring if r.mode is InferenceMode.EAGER])

    @property
    def decisions(self) -> list[Decided]:
        """What was decided and why, since it was last taken away."""
        return self._decider.decisions

    def choose_node(self) -> Node | None:
        """Return the open node to visit next: depth first if no rule says otherwise."""
        node = self._tree.newest()
        if self._has_node_rules and node is not None:
            node = self._ruled_node(node)
        self._tree.go_to(node)
        return node

    def _ruled_node(self, newest: Node) -> Node | None:
        """Return the open node that the rules choose, None if they reject all."""
        opened = self._tree.open
        views = tuple(opened[number].view() for number in reversed(opened))
        filtered = self._decider.filter(Choice.NODE, newest, views)
        if not filtered.candidates:
            return None
        picked = self._decider.pick(Choice.NODE, newest, filtered)
        assert isinstance(picked.chosen, NodeView)
        node = opened[picked.chosen.number]
        if picked.fired:
            self._decider.note_node(newest, node, picked)
        return node

    def is_spent(self, node: Node) -> bool:
        """Say whether a node at which something may be left to try has nothing left."""
        return self._chooser.is_spent(node)

    def expand(self, node: Node) -> Node | Failure | None:
        """Make a child of ``node``; None when an older node has nothing left to try."""
        match node.kind:
            case NodeKind.GOAL:
                return self._goal(node)
            case NodeKind.OPERATOR:
                return self._operator(node)
            case NodeKind.BINDING if node.failure == "" and not node.children:
                return self._check_binding(node) or self._chooser.choose(node)
        return self._chooser.choose(node)

    def _goal(self, node: Node) -> Node | Failure | None:
        assert node.goal is not None
        filtered = Filtered(tuple(node.operators or ()))
        if node.operators is None:
            operators = self._relevant(node.goal, node)
            if not operators:
                return Failure(node, "no relevant operators", structural=True)
            filtered = self._decider.filter(Choice.OPERATOR, node, tuple(operators))
            node.operators = [c for c in operators if c in filtered.candidates]
        if not node.operators:
            reason = filtered.explained("no choices for operators")
            self._refused(Choice.OPERATOR, node, filtered)
            return Failure(node, reason) if not node.children else None
        picked = self._decider.pick(Choice.OPERATOR, node, filtered)
        operator = next(o for o in node.operators if o is picked.chosen)
        node.operators = [o for o in node.operators if o is not operator]
        child = self._tree.add_operator(node, operator)
        self._decider.note(Choice.OPERATOR, node, child, picked)
        if not node.operators:
            self._tree.close(node)
        return child

    def _refused(self, choice: Choice, node: Node, filtered: Filtered) -> None:
        if filtered.fired and not node.children:
            self._decider.note_refused(choice, node, filtered)

    def _relevant(self, goal: Literal, node: Node) -> list[Operator]:
        world = self._tree.world(node.situation.state)
        for achievers in (self._achievers, self._eager):
            known = achievers.get((goal.predicate, goal.positive), ())
            relevant = [o for o in known if is_relevant(o, goal, world)]
            if relevant:
                return relevant
        return []

    def _operator(self, node: Node) -> Node | Failure | None:
        filtered = Filtered(tuple(node.instances or ()))
        if node.instances is None:
            found = self._bindings(node)
            if isinstance(found, Failure):
                return found
            filtered = found
            node.instances = [i for i in found.candidates if isinstance(i, Instance)]
        if not node.instances:
            return None
        picked = self._decider.pick(Choice.BINDINGS, node, filtered)
        instance = next(i for i in node.instances if i is picked.chosen)
        node.instances = [i for i in node.instances if i is not instance]
        child = self._tree.add_binding(node, instance, len(node.instances))
        self._decider.note(Choice.BINDINGS, node, child, picked)
        if not node.instances:
            self._tree.close(node)
        return child

    def _bindings(self, node: Node) -> Filtered | Failure:
        assert node.operator is not None
        assert node.goal is not None
        world = self._tree.world(node.situation.state)
        loop = looping_operator(node, world)
        if loop is not None:
            return Failure(node, f"goal loop with node {loop.number}", structural=True)
        try:
            made = tuple(self._bounded(instances_for(node.operator, node.goal, world)))
        except TooManyValuesError as error:
            limit = Limit(LimitKind.BINDINGS, error.most)
            return Failure(node, f"more than {error.most} bindings to try", limit=limit)
        # The first three nodes are made by hand: no rule speaks of *finish*.
        rules = RuleSet() if node.operator.name == FINISH else self._decider.rules
        filtered = filter_candidates(rules, Choice.BINDINGS, self._decider.view(node), made)
        kept = {id(c) for c in filtered.candidates}
        instances = [i for i in made if id(i) in kept]
        if not instances:
            structural = not made and not any(v.calls for v in node.operator.variables)
            reason = filtered.explained("no choices for bindings (I tried)")
            self._refused(Choice.BINDINGS, node, filtered)
            return Failure(node, reason, structural)
        if self._options.min_conspiracy_number:
            holds = world.state.holds
            instances.sort(key=lambda i: sum(not holds(p) for p in i.preconditions))
        return Filtered(tuple(instances), filtered.fired)

    def _bounded(self, instances: Iterable[Instance]) -> Iterator[Instance]:
        """Yield instances, whose values and literals count as those that are only tried."""
        for instance in instances:
            self._tree.budget.spend(len(instance.bindings) + len(instance.preconditions))
            yield instance

    def _check_binding(self, node: Node) -> Failure | None:
        for literal in node.situation.lacks(node):
            if (literal.predicate, literal.positive) not in self._tree.domain.changed:
                return Failure(node, "requires an unsolvable precondition", structural=True)
            ancestor = looping_ancestor(node, literal)
            if ancestor is not None:
                return Failure(node, f"goal loop with node {ancestor.number}", structural=True)
        return None


def _by_effect(operators: Iterable[Operator]) -> dict[tuple[str, bool], list[Operator]]:
    """Return the operators by what they make true (True) or false (False)."""
    found: dict[tuple[str, bool], dict[str, Operator]] = {}
    for operator in operators:
        for effect in operator.effects:
            key = (effect.atom.predicate, effect.adds)
            found.setdefault(key, {})[operator.name] = operator
    return {key: list(named.values()) for key, named in found.items()}
