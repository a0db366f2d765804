"""Goal loops and state loops."""

from __future__ import annotations

from rogue.prodigy._grounding import World
from rogue.prodigy._instances import regressed
from rogue.prodigy._nodes import Node
from rogue.prodigy._terms import Literal


def looping_operator(node: Node, world: World) -> Node | None:
    """Return a goal above an operator node that every way to use the operator needs again."""
    if node.operator is None or node.goal is None or node.goal_node is None:
        return None
    above = _goals_above(node.goal_node)
    found: Node | None = None
    for literals in regressed(node.operator, node.goal, world):
        loops = [above[p] for p in literals if p in above and not world.state.holds(p)]
        if not loops:
            return None
        found = loops[0]
    return found


def looping_ancestor(node: Node, literal: Literal) -> Node | None:
    """Return the goal node that a precondition of a binding node repeats on every path up."""
    return _goals_above(node.goal_node).get(literal) if node.goal_node else None


def _goals_above(goal_node: Node) -> dict[Literal, Node]:
    """Return the goals on every path from ``goal_node`` to (done), itself included."""
    assert goal_node.goal is not None
    shared: dict[Literal, Node] | None = None
    for consumer in goal_node.needed_by:
        if consumer.goal_node is None:
            continue
        above = _goals_above(consumer.goal_node)
        shared = above if shared is None else {g: n for g, n in shared.items() if g in above}
    return {**(shared or {}), goal_node.goal: goal_node}


def repeats_state(applied: Node) -> bool:
    """Say whether an applied node leads to a state in which the path already was."""
    node = applied.parent
    while node is not None:
        if node.situation.state == applied.situation.state:
            return True
        while node.parent is not None and node.situation.state is node.parent.situation.state:
            node = node.parent
        node = node.parent
    return False
