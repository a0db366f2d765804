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

MOST_NAMED = 3
"""How many things one text names."""


def waiting_for(node: Node, graph: Graph, pools: Pools, *, suspended: bool) -> str | None:
    """Say what the node waits for; None when it waits for nothing but its own handler."""
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
    return None


def _end_words(node: Node) -> str:
    if node.handling is Handling.HANDLING:
        return f"its handler in {node.handler} to stop"
    return f"{len(node.alive)} below it to end"


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
    is_step_below = source.id in node.alive and source.point is Point.END_ACHIEVING
    if other is None or source.point is None or source.id == node.id:
        return []
    if is_step_below and other.origin.gate is None:
        return []
    later = f" and {source.delay:g} s more" if source.delay else ""
    return [f"{other.task.name} {other.id} {_WORDS[source.point]}{later}"]


def _twin_words(node: Node, graph: Graph) -> list[str]:
    """What a point waits for by way of the points that pass together with it."""
    words: dict[str, None] = {}
    for twins in node.twins.values():
        for id, point in twins:
            twin = graph.nodes.get(id)
            if twin is not None and twin.open[point]:
                for source in twin.open[point]:
                    words.update(dict.fromkeys(_source_words(twin, graph, source)))
    return list(words)


def _pending_words(node: Node, pools: Pools) -> str:
    name = node.task.name
    if node.handling is Handling.HANDLING:
        return f"{node.handler} to take it"
    providers = pools.provides(name)
    if node.only is not None:
        return f"module {node.only!r} to be back"
    if not providers:
        return f"a module that handles {name!r}"
    return " or ".join(f"{p.module}, which has {p.load(name)} of {name!r}" for p in providers)
