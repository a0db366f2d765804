"""Search trees as text."""

from __future__ import annotations

from collections.abc import Iterable

from rogue.prodigy._events import NodeKind, NodeView

_MARKS = {
    NodeKind.GOAL: ("(", ")"),
    NodeKind.OPERATOR: ("", ""),
    NodeKind.BINDING: ("<", ">"),
    NodeKind.APPLIED: ("[", "]"),
}


def render_tree(nodes: Iterable[NodeView]) -> str:
    """Return the goal tree of a search as indented text, one node a line.

    Goals stand under the operator that needs them, applied operators in square brackets with
    ``*`` if they were executed, failures with their reason. Roots and *finish* are left out.

    Args:
        nodes: As ``Search.nodes()`` gives them.
    """
    return "\n".join(_line(node) for node in nodes if node.parent and node.literal is not None)


def _line(node: NodeView) -> str:
    opening, closing = _MARKS[node.kind]
    text = node.text.strip("<>()") if opening else node.text
    if node.kind is NodeKind.GOAL and node.literal is not None and not node.literal.positive:
        text, opening, closing = node.text, "", ""
    executed = " *" if node.executed else ""
    failed = f"  -- {node.failure}" if node.failure else ""
    return f"{'  ' * node.level}n{node.number} {opening}{text}{closing}{executed}{failed}"
