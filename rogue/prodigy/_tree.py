"""The search tree: making nodes, what is so at each, which are open, what is committed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from rogue.prodigy._domain import Operator
from rogue.prodigy._effects import changes
from rogue.prodigy._events import NodeKind
from rogue.prodigy._grounding import World
from rogue.prodigy._instance import Instance
from rogue.prodigy._instances import DONE, all_instances, finish_operator
from rogue.prodigy._nodes import Node, Situation
from rogue.prodigy._problem import Problem
from rogue.prodigy._state import State
from rogue.prodigy._tail import Tail
from rogue.prodigy._terms import Literal


class Tree:
    """Nodes of one search.

    Attributes:
        domain: What can be done.
        objects: What there is; grows when objects are added.
        nodes: All nodes, by number less one.
        open: Nodes with something left to try, oldest first; the last is visited next.
        barrier: The newest node that cannot be undone: a root or an executed node.
        extra: Goals that came after the start.
        removed: Goals that were dropped.
    """

    def __init__(self, problem: Problem) -> None:
        self.domain = problem.domain
        self.objects = problem.objects
        self.nodes: list[Node] = []
        self.open: list[Node] = []
        self.extra: list[Literal] = []
        self.removed: set[Literal] = set()
        self._finish = finish_operator(problem.variables, problem.goal)
        self.barrier = self.plant(problem.state)

    def plant(self, state: State) -> Node:
        """Make a root with its goal (done) and operator *finish*; return the root."""
        root = self._make(NodeKind.APPLIED, None, 0, Situation(state, {}, ()))
        goal = self._make(NodeKind.GOAL, root, 0, Situation(state, {}, ()), goal=DONE)
        goal.operators = []
        root.visited = goal.visited = True
        finish = self._make(
            NodeKind.OPERATOR,
            goal,
            0,
            goal.situation,
            goal=DONE,
            operator=self._finish,
            goal_node=goal,
        )
        self.barrier = root
        self.open = [finish]
        return root

    def _make(
        self,
        kind: NodeKind,
        parent: Node | None,
        level: int,
        situation: Situation,
        *,
        goal: Literal | None = None,
        operator: Operator | None = None,
        instance: Instance | None = None,
        goal_node: Node | None = None,
        binding: Node | None = None,
        needed_by: tuple[Node, ...] = (),
        alternatives: int = 0,
    ) -> Node:
        node = Node(
            len(self.nodes) + 1,
            kind,
            parent,
            parent.depth + 1 if parent else 1,
            level,
            situation,
            goal,
            operator,
            instance,
            goal_node,
            binding,
            needed_by,
            alternatives,
        )
        self.nodes.append(node)
        if parent is not None:
            parent.children.append(node)
            self.open.append(node)
        return node

    def add_goal(self, parent: Node, goal: Literal, needed_by: list[Node], others: int) -> Node:
        """Make a goal node under a binding or applied node."""
        node = self._make(
            NodeKind.GOAL,
            parent,
            needed_by[0].level + 1,
            parent.situation,
            goal=goal,
            needed_by=tuple(needed_by),
            alternatives=others,
        )
        node.situation = self._derived(node, parent.situation)
        return node

    def add_operator(self, parent: Node, operator: Operator) -> Node:
        """Make an operator node under a goal node."""
        return self._make(
            NodeKind.OPERATOR,
            parent,
            parent.level,
            parent.situation,
            goal=parent.goal,
            operator=operator,
            goal_node=parent,
        )

    def add_binding(self, parent: Node, instance: Instance, others: int) -> Node:
        """Make a binding node under an operator node."""
        node = self._make(
            NodeKind.BINDING,
            parent,
            parent.level,
            parent.situation,
            goal=parent.goal,
            operator=instance.operator,
            instance=replace(instance, node=len(self.nodes) + 1),
            goal_node=parent.goal_node,
            alternatives=others,
        )
        node.situation = self._derived(node, parent.situation)
        return node

    def add_applied(self, parent: Node, binding: Node) -> Node:
        """Make an applied node under a binding or applied node."""
        node = self._make(
            NodeKind.APPLIED,
            parent,
            binding.level,
            parent.situation,
            goal=binding.goal,
            operator=binding.operator,
            instance=binding.instance,
            binding=binding,
        )
        node.situation = self._derived(node, parent.situation)
        return node

    def needs(self, node: Node) -> tuple[Literal, ...]:
        """Return the preconditions of a binding node."""
        assert node.instance is not None
        if not node.is_finish():
            return node.instance.preconditions
        kept = [p for p in node.instance.preconditions if p not in self.removed]
        return tuple(dict.fromkeys([*kept, *self.extra]))

    def goal_sets(self, state: State) -> Iterator[tuple[Literal, ...]]:
        """Yield the sets of literals each of which is what is wanted now."""
        for instance in all_instances(self._finish, self.world(state)):
            kept = [p for p in instance.preconditions if p not in self.removed]
            yield tuple(dict.fromkeys([*kept, *self.extra]))

    def world(self, state: State) -> World:
        """Return a state with what is needed to ask about it."""
        return World(self.domain, self.objects, state)

    def close(self, node: Node) -> None:
        """Take a node out of the open ones."""
        node.closed = True
        if node in self.open:
            self.open.remove(node)

    def commit(self, node: Node) -> None:
        """Make ``node`` the barrier: nothing before it is ever tried again."""
        for older in self.open:
            older.closed = older is not node
        self.open = [node]
        self.barrier = node

    def holds_in(self, node: Node, situation: Situation) -> bool:
        """Say whether the preconditions of a binding node hold in ``situation``."""
        return all(map(situation.state.holds, self.needs(node)))

    def before(self, applied: Node) -> Situation:
        """Return the situation before an applied node's changes, its operator taken out."""
        assert applied.parent is not None
        situation = applied.parent.situation
        tail = tuple(n for n in situation.tail if n is not applied.binding)
        return Situation(situation.state, situation.expanded, tail)

    def shifted(
        self, situation: Situation, added: Iterable[Literal], deleted: Iterable[Literal]
    ) -> Situation:
        """Return ``situation`` after changes of facts.

        What changes is no longer a goal being worked on. Nor is a goal whose operator now lacks
        what nothing can bring about: it has to be reached in another way.
        """
        state = situation.state.changed(added, deleted)
        changed = set(state.difference(situation.state))
        expanded = {
            goal: node
            for goal, node in situation.expanded.items()
            if (goal if goal.positive else goal.negated()) not in changed
        }
        for node in situation.tail:
            if node.goal in expanded and self.is_hopeless(node, state):
                del expanded[node.goal]
        return Situation(state, expanded, situation.tail)

    def is_hopeless(self, node: Node, state: State) -> bool:
        """Say whether a binding node lacks a precondition that no operator makes true."""
        return not node.is_finish() and any(
            not state.holds(p) and (p.predicate, p.positive) not in self.domain.changed
            for p in self.needs(node)
        )

    def _derived(self, node: Node, above: Situation) -> Situation:
        match node.kind:
            case NodeKind.GOAL if node.goal is not None and not above.state.holds(node.goal):
                expanded = {**above.expanded, node.goal: node}
                return Situation(above.state, expanded, above.tail)
            case NodeKind.BINDING:
                expanded = dict(above.expanded)
                if node.goal in expanded and self.is_hopeless(node, above.state):
                    del expanded[node.goal]
                return Situation(above.state, expanded, (*above.tail, node))
            case NodeKind.APPLIED:
                return self._applied(node, above)
        return above

    def _applied(self, node: Node, above: Situation) -> Situation:
        assert node.instance is not None
        made = changes(node.instance, self.world(above.state))
        return self.outcome(node, above, made.added, made.deleted)

    def outcome(
        self,
        applied: Node,
        above: Situation,
        added: Iterable[Literal],
        deleted: Iterable[Literal],
    ) -> Situation:
        """Return the situation after an operator was applied with the given changes."""
        tail = tuple(n for n in above.tail if n is not applied.binding)
        expanded = {goal: node for goal, node in above.expanded.items() if goal != applied.goal}
        return self.shifted(Situation(above.state, expanded, tail), added, deleted)

    def path(self) -> list[Node]:
        """Return the nodes from the barrier to the node visited next, or only the barrier."""
        node: Node | None = self.open[-1] if self.open else self.barrier
        path: list[Node] = []
        while node is not None and node is not self.barrier:
            path.append(node)
            node = node.parent
        return [self.barrier, *reversed(path)]

    def change(
        self, added: Iterable[Literal], deleted: Iterable[Literal], *, executing: bool = False
    ) -> None:
        """Take in a change of the world: it is so from the barrier on, whatever is tried.

        Choices on the path are open again; an applied operator that is no longer ready, or a
        goal that is no longer wanted, is given up with what follows it; not so while the last
        operator of the path is executing.
        """
        path = self.path()
        self.barrier.situation = self.shifted(self.barrier.situation, added, deleted)
        kept = [self.barrier]
        for node in path[1:]:
            above = kept[-1].situation
            if not executing and not self._still_makes_sense(node, above):
                break
            node.situation = self._derived(node, above)
            kept.append(node)
        self._reopen(kept)

    def _still_makes_sense(self, node: Node, above: Situation) -> bool:
        if node.binding is not None:
            return self.holds_in(node.binding, above)
        if node.kind is NodeKind.GOAL and node.goal != DONE:
            return node.goal in Tail(above, self.needs).pending()
        return True

    def _reopen(self, path: list[Node]) -> None:
        for node in self.open:
            node.closed = True
        self.open = []
        for node in path:
            is_choice = node.kind in {NodeKind.BINDING, NodeKind.APPLIED}
            if is_choice:
                node.tried.clear()
                node.only_apply = False
            if node.parent is not None and (is_choice or _has_untried(node)):
                node.closed = False
                self.open.append(node)


def _has_untried(node: Node) -> bool:
    """Say whether a goal or operator node was not expanded yet or has candidates left."""
    left = node.operators if node.kind is NodeKind.GOAL else node.instances
    return left is None or bool(left)
