"""The search as control rules see it."""

from __future__ import annotations

from rogue.prodigy._domain import Operator
from rogue.prodigy._events import NodeKind
from rogue.prodigy._instance import Instance
from rogue.prodigy._nodes import Node
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal
from rogue.prodigy._types import Objects, TypeSpec


class RunningView:
    """A ``SearchView`` of the node being expanded."""

    def __init__(self, node: Node, objects: Objects) -> None:
        self._node = node
        self._objects = objects
        self._tail = node.situation.view

    @property
    def state(self) -> State:
        """The simulated world."""
        return self._node.situation.state

    @property
    def objects(self) -> Objects:
        """What there is."""
        return self._objects

    @property
    def goal(self) -> Literal | None:
        """The goal for which an operator or bindings are being chosen; None elsewhere."""
        is_choosing = self._node.kind in {NodeKind.GOAL, NodeKind.OPERATOR}
        return self._node.goal if is_choosing else None

    @property
    def operator(self) -> Operator | None:
        """The operator for which bindings are being chosen; None elsewhere."""
        return self._node.operator if self._node.kind is NodeKind.OPERATOR else None

    def consumers(self, goal: Literal) -> tuple[Instance, ...]:
        """Return the live, not yet applied operators that need ``goal``."""
        return tuple(n.instance for n in self._tail.consumers(goal) if n.instance)

    def lacking(self, instance: Instance) -> tuple[Literal, ...]:
        """Return the preconditions of ``instance`` that are false now."""
        return tuple(p for p in instance.preconditions if not self.state.holds(p))

    def top_level_goals(self, candidate: Literal | Instance) -> tuple[Literal, ...]:
        """Return the goals of the problem that ``candidate`` serves in the end."""
        if isinstance(candidate, Instance) and not candidate.node and candidate.goal:
            candidate = candidate.goal
        return tuple(self._tail.top_level_goals(candidate))

    def pending_goals(self) -> tuple[Literal, ...]:
        """Return the goals needed, false and not yet worked on, before any rule."""
        return tuple(self._tail.pending())

    def ready(self) -> tuple[Instance, ...]:
        """Return the operators that could be applied, newest first, before any rule."""
        return tuple(n.instance for n in self._tail.ready() if n.instance)

    def expanded_goals(self) -> tuple[Literal, ...]:
        """Return the goals being worked on, oldest first."""
        expanded = self._node.situation.expanded
        return tuple(sorted(expanded, key=lambda goal: expanded[goal].number))

    def goals(self) -> tuple[Literal, ...]:
        """Return the goals of the problem now."""
        return self._tail.goals()

    def objects_of(self, kind: str) -> tuple[str, ...]:
        """Return the objects of a type, in the order of their declaration."""
        return self._objects.of(TypeSpec((kind,)))

    def tail(self) -> tuple[Instance, ...]:
        """Return the chosen and not yet applied operators of this path, oldest first."""
        tail = self._node.situation.tail
        return tuple(n.instance for _, n in sorted(tail.items()) if n.instance)
