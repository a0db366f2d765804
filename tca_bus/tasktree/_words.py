"""What a node waits for, in words."""

from __future__ import annotations

from tca_bus._orders import Point
from tca_bus._protocol import Handling, TaskState
from tca_bus.tasktree._graph import Graph
from tca_bus.tasktree._node import Node, Source
from tca_bus.tasktree._pools import Pools

_WORDS = {
    Point.START_HANDLING: "to be taken by its handler",
    Point.END_HANDLING: "to be handled",
    Point.START_PLANNING: "to start planning",
    Point.END_PLANNING: "to be planned",
    Point.START_ACHIEVING: "to start being achieved",
    Point.END_ACHIEVING: "to be achieved",
}

BELOW = "what is below it to end"

MOST_NAMED = 3
"""How many things one text names."""


def waiting_for(node: Node, graph: Graph, pools: Pools, *, suspended: bool) -> str | None:
    """Say what the node waits for; None when it waits for nothing but its own handler.

    When several things hold it those are named that are not seen below it anyway.
    """
    if node.has_ended:
        return None
    if node.prepared:
        return f"{node.task.sender} to send it"
    if node.failing:
        return _recovery_words(node, graph)
    if not node.is_alive or node.restarting:
        return _end_words(node)
    state = node.state()
    if state in {TaskState.INACTIVE, TaskState.PENDING} and suspended and not node.is_handling:
        return "being resumed"
    if state is TaskState.INACTIVE:
        return _constraint_words(node, graph)
    if state is TaskState.PENDING:
        return _pending_words(node, pools)
    if node.handling is Handling.HANDLED:
        return _constraint_words(node, graph) or BELOW
    return None


def _end_words(node: Node) -> str:
    if node.handling is Handling.HANDLING:
        return f"its handler in {node.handler} to stop"
    return BELOW


def _recovery_words(node: Node, graph: Graph) -> str:
    why = node.failure.name if node.failure else "its failure"
    if node.open[Point.START_RECOVERY]:
        return _constraint_words(node, graph, only=Point.START_RECOVERY)
    handler = node.recovery.handler if node.recovery else "an exception handler"
    return f"{handler} to deal with {why}"


def _constraint_words(node: Node, graph: Graph, *, only: Point | None = None) -> str:
    found: dict[str, None] = {}
    for point, sources in node.open.items():
        if only in {None, point}:
            for source in sources:
                found.update(dict.fromkeys(_source_words(node, graph, source)))
    texts = list(found) or _twin_words(node, graph)
    more = f" and {len(texts) - MOST_NAMED} more" if len(texts) > MOST_NAMED else ""
    return ", ".join(texts[:MOST_NAMED]) + more


def _source_words(node: Node, graph: Graph, source: Source) -> list[str]:
    if source.alarm:
        when = node.alarms.get(source.alarm, 0.0)
        return [f"the time {when:.1f}"]
    other = graph.nodes.get(source.id)
    if other is None or source.point is None or source.id == node.id:
        return []
    if source.id in node.alive and other.origin.gate is None:
        return []
    later = f" and {source.delay:g} s more" if source.delay else ""
    return [f"{other.task.name} {other.id} {_WORDS[source.point]}{later}"]


def _twin_words(node: Node, graph: Graph) -> list[str]:
    """What a point waits for by way of the points that pass together with it."""
    words: dict[str, None] = {}
    for point in node.twins:
        for twin, own_point in graph.together(node, point):
            if twin is not node:
                words.update(dict.fromkeys(_words_of_twin(twin, own_point, graph)))
    return list(words)


def _words_of_twin(twin: Node, point: Point, graph: Graph) -> list[str]:
    if twin.prepared:
        return [f"{twin.task.sender} to send {twin.task.name} {twin.id}"]
    found = [text for each in twin.open[point] for text in _source_words(twin, graph, each)]
    if found or (twin.is_alive and not twin.open[point]):
        return found
    return [f"{twin.task.name} {twin.id} {_WORDS[point]}"]


def _pending_words(node: Node, pools: Pools) -> str:
    if node.handling is Handling.HANDLING:
        return f"{node.handler} to take it"
    if node.only is not None:
        return f"module {node.only!r} to be back"
    return pools.why(node.id, node.task.name)
