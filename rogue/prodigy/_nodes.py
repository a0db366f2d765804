"""Nodes of the search tree."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from immutables import Map

from rogue.prodigy._domain import InferenceRule, Operator
from rogue.prodigy._events import NodeKind, NodeView, StepView
from rogue.prodigy._instance import Instance
from rogue.prodigy._instances import FINISH
from rogue.prodigy._situation import Situation
from rogue.prodigy._terms import Literal

if TYPE_CHECKING:
    from rogue.prodigy._protect import Protection


@dataclass(slots=True, eq=False)
class Node:
    """A node of the search tree.

    Attributes:
        number: In order of making, from 1.
        kind: What it decides.
        parent: None for a root.
        depth: In the search tree, from 1.
        level: In the goal tree, from 0.
        situation: What is so after this node.
        before: For applied nodes, the same before its changes, with its operator taken out.
        goal: The goal of a goal node, or the one that an operator serves.
        operator: Set for all but goal nodes and roots.
        instance: Set for binding and applied nodes.
        goal_node: For operator and binding nodes, the goal node above.
        binding: For applied nodes, the binding node applied.
        needed_by: For goal nodes, the binding nodes that need the goal, newest first.
        alternatives: How many other candidates the choice had left when this was made.
        operators: Candidates still to be tried, of a goal node.
        instances: Candidates still to be tried, of an operator node.
        tried: Goals and binding nodes already taken at a binding or applied node.
        only_apply: The other goals here were given up, as SABA does.
        structural: It failed for reasons that no other order of steps changes.
        steps: How many operators were applied down to here.
        cost: What they cost, once that was asked for.
        is_unsettled: Whether something is left to try here was not looked at yet.
        goals_above: For goal nodes, the goals on every path up to (done), once they were asked for.
        protection: For protection nodes, what they protect and how.
        decided_by: The rule, or the default, that chose it.
    """

    number: int
    kind: NodeKind
    parent: Node | None
    depth: int
    level: int
    situation: Situation
    goal: Literal | None = None
    operator: Operator | None = None
    instance: Instance | None = None
    goal_node: Node | None = None
    binding: Node | None = None
    needed_by: tuple[Node, ...] = ()
    alternatives: int = 0
    operators: list[Operator] | None = None
    instances: list[Instance] | None = None
    tried: set[object] = field(default_factory=set)
    children: list[Node] = field(default_factory=list)
    only_apply: bool = False
    structural: bool = False
    closed: bool = False
    visited: bool = False
    executed: bool = False
    failure: str = ""
    decided_by: str = ""
    before: Situation | None = None
    steps: int = 0
    cost: float | None = None
    is_unsettled: bool = False
    goals_above: Map[Literal, Node] | None = None
    protection: Protection | None = None

    def text(self) -> str:
        """Return what is printed behind the number."""
        if self.kind is NodeKind.GOAL:
            return str(self.goal)
        if self.protection is not None:
            return str(self.protection)
        if self.instance is not None:
            shown = str(self.instance)
            return shown.upper() if self.kind is NodeKind.APPLIED else shown
        return self.operator.name if self.operator else "root"

    def is_finish(self) -> bool:
        """Say whether this is a binding of *finish*."""
        return self.instance is not None and self.instance.name == FINISH

    def is_applicable(self) -> bool:
        """Say whether this binds an operator, neither an inference rule nor *finish*."""
        return not self.is_finish() and not isinstance(self.operator, InferenceRule)

    def is_choice(self) -> bool:
        """Say whether "apply or sub-goal?" is asked here."""
        return self.kind not in {NodeKind.GOAL, NodeKind.OPERATOR}

    def is_root(self) -> bool:
        """Say whether this is the applied operator of nothing at which a search starts."""
        return self.kind is NodeKind.APPLIED and self.instance is None

    def is_step(self) -> bool:
        """Say whether an operator was applied here."""
        return self.kind is NodeKind.APPLIED and self.instance is not None

    def view(self) -> NodeView:
        """Return the node as a frozen value."""
        return NodeView(
            self.number,
            self.kind,
            self.text(),
            self.depth,
            self.level,
            self.parent.number if self.parent else 0,
            self.goal,
            self.operator.name if self.operator else "",
            self.instance.args if self.instance else (),
            self.failure,
            self.executed,
            tuple(node.number for node in self.above()),
            self.instance.preconditions if self.instance else (),
        )

    def above(self) -> tuple[Node, ...]:
        """Return what it hangs from in the goal tree."""
        if self.kind is NodeKind.GOAL:
            return self.needed_by
        one = self.binding if self.kind is NodeKind.APPLIED else self.goal_node
        return (one,) if one else ()

    def step(self) -> StepView:
        """Return the instance of a binding or applied node as a step of a plan."""
        assert self.instance is not None
        bindings = tuple(sorted(self.instance.bindings.items()))
        return StepView(self.number, self.instance.name, self.instance.args, bindings)
