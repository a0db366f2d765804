"""Goal loops."""

from __future__ import annotations

from immutables import Map

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


def _goals_above(goal_node: Node) -> Map[Literal, Node]:
    """Return the goals on every path from ``goal_node`` to (done), itself included.

    Each goal node keeps its answer: nothing of it changes once the node is made.
    """
    agenda = [goal_node]
    while agenda:
        node = agenda[-1]
        above = [c.goal_node for c in node.needed_by if c.goal_node is not None]
        missing = [n for n in above if n.goals_above is None]
        if missing and node.goals_above is None:
            agenda.extend(missing)
            continue
        agenda.pop()
        if node.goals_above is None and node.goal is not None:
            known = [n.goals_above for n in above if n.goals_above is not None]
            node.goals_above = _on_all(known).set(node.goal, node)
    assert goal_node.goals_above is not None
    return goal_node.goals_above


def _on_all(paths: list[Map[Literal, Node]]) -> Map[Literal, Node]:
    if len(paths) == 1:
        return paths[0]
    first, *others = sorted(paths, key=len) or [Map()]
    return Map({goal: node for goal, node in first.items() if all(goal in o for o in others)})
