"""What a node waits for, in words."""

from __future__ import annotations

from collections.abc import Mapping

from tca_bus._protocol import Handling, TaskState
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._points import Point
from tca_bus.tasktree._pools import Pools

_WORDS = {
    Point.START_HANDLING: "to be taken by its handler",
    Point.END_HANDLING: "to be handled",
    Point.START_PLANNING: "to start planning",
    Point.END_PLANNING: "to be planned",
    Point.START_ACHIEVING: "to start being achieved",
    Point.END_ACHIEVING: "to be achieved",
}

MOST_NAMED = 3
"""How many things one text names."""


def waiting_for(node: Node, nodes: Mapping[str, Node], pools: Pools) -> str | None:
    """Say what the node waits for; None when it waits for nothing but its own handler."""
    if node.has_ended:
        return None
    if not node.is_alive or node.restarting:
        return _end_words(node)
    state = node.state()
    if state is TaskState.INACTIVE:
        return _constraint_words(node, nodes)
    if state is TaskState.PENDING:
        return _pending_words(node, pools)
    return None


def _end_words(node: Node) -> str:
    if node.handling is Handling.HANDLING:
        return f"its handler in {node.handler} to stop"
    return f"{len(node.alive)} below it to end"


def _constraint_words(node: Node, nodes: Mapping[str, Node]) -> str:
    found: dict[str, None] = {}
    for points in node.open.values():
        for id, point in points:
            if id != node.id and id not in node.alive and id in nodes:
                found[f"{nodes[id].task.name} {id} {_WORDS[point]}"] = None
    texts = list(found)
    more = f" and {len(texts) - MOST_NAMED} more" if len(texts) > MOST_NAMED else ""
    return ", ".join(texts[:MOST_NAMED]) + more


def _pending_words(node: Node, pools: Pools) -> str:
    name = node.task.name
    if node.handling is Handling.HANDLING:
        return f"{node.handler} to take it"
    providers = pools.provides(name)
    if not providers:
        return f"a module that handles {name!r}"
    return " or ".join(f"{p.module}, which has {p.load(name)} of {name!r}" for p in providers)
