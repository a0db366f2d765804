"""Propagation of failures: what cannot succeed because something below it failed is closed."""

from __future__ import annotations

from rogue.prodigy._events import NodeKind
from rogue.prodigy._nodes import Node
from rogue.prodigy._tree import Tree


def excise(node: Node, tree: Tree) -> None:
    """Close what cannot succeed because ``node`` failed whatever the order of steps.

    An operator all of whose bindings failed so is closed, then its goal, then the operator that
    needs the goal with everything below it, and so on upwards, as far as the state is the same:
    in the state before an application the goal may still be within reach. PRODIGY4.0 calls the
    switch ``excise-loops``.
    """
    applied = _newest_applied(node)
    node.structural = True
    if applied.kind is NodeKind.PROTECTION:
        # What it protects may be given up, and its operator be applied without.
        return
    while node.structural:
        if node.kind is NodeKind.GOAL and node.needed_by:
            node = _give_up(node.needed_by[0], applied, tree)
        above = node.parent
        if above is None or node is applied or above.kind is NodeKind.APPLIED:
            return
        node = above
        node.structural = not (node.instances or node.operators) and all(
            child.structural for child in node.children
        )
        if node.structural:
            tree.close(node)


def _give_up(consumer: Node, applied: Node, tree: Tree) -> Node:
    top = consumer if consumer.depth > applied.depth else applied
    for lower in [n for n in tree.open.values() if _is_at_or_below(n, top)]:
        tree.close(lower)
    top.structural = True
    top.failure = top.failure or "requires an unsolvable precondition"
    return top


def _is_at_or_below(node: Node, top: Node) -> bool:
    while node.depth > top.depth and node.parent is not None:
        node = node.parent
    return node is top


def _newest_applied(node: Node) -> Node:
    ends = {NodeKind.APPLIED, NodeKind.PROTECTION}
    while node.kind not in ends and node.parent is not None:
        node = node.parent
    return node
