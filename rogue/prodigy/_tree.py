"""The search tree: making nodes, which are open, what is committed, what is let go."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rogue.prodigy._budget import Budget
from rogue.prodigy._domain import Operator
from rogue.prodigy._events import NodeKind
from rogue.prodigy._grounding import World
from rogue.prodigy._inference import Inference
from rogue.prodigy._instance import Instance
from rogue.prodigy._instances import DONE, all_instances, finish_operator
from rogue.prodigy._nodes import Node
from rogue.prodigy._problem import Problem, conjunction
from rogue.prodigy._protect import Protection
from rogue.prodigy._situation import Situation
from rogue.prodigy._state import State
from rogue.prodigy._succession import Succession
from rogue.prodigy._terms import Literal


class Tree:
    """Nodes of one search.

    Attributes:
        domain: What can be done.
        objects: What there is; grows when objects are added.
        nodes: The nodes kept, by number.
        made: How many were ever made.
        open: Nodes with something left to try, by number, oldest first.
        at: The node that the search is at: the one it expands next, or the barrier.
        barrier: The newest node that cannot be undone: a root or an executed node.
        extra: Goals that came after the start.
        removed: Goals that were dropped.
        budget: How many values may be tried in one step.
        inference: The inference rules of the domain.
        next_situation: What is so after each kind of node.
    """

    def __init__(self, problem: Problem, budget: Budget) -> None:
        self.budget = budget
        self.domain = problem.domain
        self.objects = problem.objects
        self.nodes: dict[int, Node] = {}
        self.made = 0
        self.open: dict[int, Node] = {}
        self.extra: list[Literal] = []
        self.removed: set[Literal] = set()
        self.inference = Inference(problem.domain, [problem.goal])
        self._goal = problem.goal
        self.next_situation = Succession(self)
        self._finish = finish_operator(problem.variables, problem.goal)
        self.barrier: Node
        self.at: Node
        self.plant(problem.state)

    def plant(self, state: State) -> Node:
        """Make a root with its goal (done) and operator *finish*; return the root."""
        facts = self.inference.start(self.world(state))
        root = self._make(NodeKind.APPLIED, None, 0, Situation.at(facts))
        goal = self._make(NodeKind.GOAL, root, 0, root.situation, goal=DONE)
        goal.operators = []
        root.visited = goal.visited = True
        finish = self._make(
            NodeKind.OPERATOR,
            goal,
            0,
            root.situation,
            goal=DONE,
            operator=self._finish,
            goal_node=goal,
        )
        self.barrier = root
        self.open = {finish.number: finish}
        self.at = finish
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
        self.made += 1
        node = Node(
            self.made,
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
            steps=(parent.steps if parent else 0) + int(binding is not None),
        )
        self.nodes[node.number] = node
        if parent is not None:
            parent.children.append(node)
            self.open[node.number] = node
            self.at = node
        return node

    def add_goal(
        self, parent: Node, goal: Literal, needed_by: tuple[Node, ...], others: int
    ) -> Node:
        """Make a goal node under a binding or applied node."""
        node = self._make(
            NodeKind.GOAL,
            parent,
            needed_by[0].level + 1,
            parent.situation,
            goal=goal,
            needed_by=needed_by,
            alternatives=others,
        )
        node.situation = self.next_situation.after(node, parent.situation)
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
            instance=replace(instance, node=self.made + 1),
            goal_node=parent.goal_node,
            alternatives=others,
        )
        node.situation = self.next_situation.after(node, parent.situation)
        return node

    def add_protection(self, parent: Node, protection: Protection) -> Node:
        """Make a protection node under a binding or applied node."""
        node = self._make(
            NodeKind.PROTECTION,
            parent,
            protection.binding.level,
            parent.situation,
            goal=protection.binding.goal,
            operator=protection.binding.operator,
        )
        node.protection = protection
        node.situation = self.next_situation.after(node, parent.situation)
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
        node.situation = self.next_situation.after(node, parent.situation)
        return node

    def finish_needs(self, node: Node) -> tuple[Literal, ...]:
        """Return the goals of the problem as they are now, for a node of *finish*."""
        assert node.instance is not None
        kept = [p for p in node.instance.preconditions if p not in self.removed]
        return tuple(dict.fromkeys([*kept, *self.extra]))

    def goal_sets(self, state: State) -> Iterator[tuple[Literal, ...]]:
        """Yield the sets of goals each of which would be the end, as they are now."""
        for instance in all_instances(self._finish, self.world(state)):
            kept = [p for p in instance.preconditions if p not in self.removed]
            yield tuple(dict.fromkeys([*kept, *self.extra]))

    def world(self, state: State) -> World:
        """Return a state with what is needed to ask about it."""
        return World(self.domain, self.objects, state, self.budget)

    def newest(self) -> Node | None:
        """Return the newest open node, None if none is open."""
        return self.open[next(reversed(self.open))] if self.open else None

    def go_to(self, node: Node | None) -> None:
        """Make ``node`` the one that the search is at; None for the barrier."""
        self.at = node if node is not None else self.barrier

    def close(self, node: Node) -> None:
        """Take a node out of the open ones."""
        node.closed = True
        self.open.pop(node.number, None)
        if node is self.at:
            self.go_to(self.newest())

    def commit(self, node: Node) -> None:
        """Make ``node`` the barrier: nothing before it is ever tried again."""
        for older in self.open.values():
            older.closed = older is not node
        self.open = {node.number: node}
        self.barrier = self.at = node

    def forget(self, most: int) -> None:
        """Let old committed history go if more than ``most`` nodes are held.

        Half as many are kept, and whatever the tail still refers to.
        """
        if len(self.nodes) <= most:
            return
        oldest = min(self.barrier.number, self.made - most // 2)
        situation = self.barrier.situation
        kept = {n.number: n for n in (*situation.tail.values(), *situation.expanded.values())}
        kept.update((n.goal_node.number, n.goal_node) for n in [*kept.values()] if n.goal_node)
        for number in [n for n in self.nodes if n < oldest]:
            node = self.nodes[number]
            node.parent, node.children, node.before = None, [], None
            if number not in kept:
                del self.nodes[number]
        if len(situation.past) > most:
            self.barrier.situation = situation.without_past()

    def change_goals(self, goals: tuple[Literal, ...], dropped: tuple[Literal, ...]) -> None:
        """Add and drop goals of the problem; what is so follows with the next change."""
        self.extra = [g for g in self.extra if g not in (*goals, *dropped)]
        self.extra.extend(goals)
        if any(not goal.positive for goal in goals) and not self.inference.is_idle:
            self.inference = Inference(self.domain, [self._goal, conjunction(self.extra)])
        finish = self.at.situation.finish
        known = finish.instance.preconditions if finish and finish.instance else dropped
        self.removed.update(goal for goal in dropped if goal in known)

    def path(self) -> list[Node]:
        """Return the nodes from the barrier to where the search is."""
        node: Node | None = self.at
        path: list[Node] = []
        while node is not None and node is not self.barrier:
            path.append(node)
            node = node.parent
        return [self.barrier, *reversed(path)]

    def reopen(self, path: list[Node]) -> None:
        """Open the nodes of a path again, with every choice on it, and no others."""
        for node in self.open.values():
            node.closed = True
        self.open = {}
        for node in path:
            is_choice = node.is_choice()
            if is_choice:
                node.tried.clear()
                node.only_apply = False
            if not node.is_root() and (is_choice or _has_untried(node)):
                node.closed = False
                self.open[node.number] = node
        self.go_to(self.newest())


def _has_untried(node: Node) -> bool:
    """Say whether a goal or operator node was not expanded yet or has candidates left."""
    left = node.operators if node.kind is NodeKind.GOAL else node.instances
    return left is None or bool(left)
