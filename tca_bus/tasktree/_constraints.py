"""Which points a node waits for: its flags, the implicit constraints, and those that were sent.

Source: TCA's flags as in Simmons (1994), the implicit constraints as TCM has them: planning and
achievement of a node enclose those of its children; a goal is handled from the start of its
planning, a command from the start of its achievement and is planned from birth.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from tca_bus._errors import RefusedError
from tca_bus._orders import Order, Point
from tca_bus._protocol import Constraint
from tca_bus.tasktree._events import Role
from tca_bus.tasktree._node import Node, PointOf

Edge = tuple[PointOf, PointOf]
"""The first point passes before, or together with, the second."""


def own_edges(node: Node) -> Iterator[Edge]:
    """The constraints of a node between its own points; a place has no flags yet."""
    id = node.id
    yield (id, Point.END_HANDLING), (id, Point.END_ACHIEVING)
    yield (id, Point.START_ACHIEVING), (id, Point.END_ACHIEVING)
    if not node.is_goal:
        yield (id, Point.START_ACHIEVING), (id, Point.START_HANDLING)
        return
    yield (id, Point.START_PLANNING), (id, Point.START_HANDLING)
    yield (id, Point.END_HANDLING), (id, Point.END_PLANNING)
    yield (id, Point.END_PLANNING), (id, Point.END_ACHIEVING)
    if node.prepared:
        return
    if Constraint.DELAY_PLANNING in flags_of(node):
        yield (id, Point.START_ACHIEVING), (id, Point.START_PLANNING)
    else:
        yield (id, Point.START_HANDLING), (id, Point.START_ACHIEVING)
    if Constraint.PLAN_FIRST in flags_of(node):
        yield (id, Point.END_PLANNING), (id, Point.START_ACHIEVING)


def delayed_edges(node: Node) -> Iterator[tuple[Edge, float]]:
    """What a place's start of planning waits for holds its start of achievement as well.

    So it is under DELAY_PLANNING, which a place does not know of. Each comes with its delay.
    """
    if node.is_goal and Constraint.DELAY_PLANNING in flags_of(node):
        for source in node.open.get(Point.START_PLANNING, ()):
            if source.point is not None and source.id != node.id:
                edge = (source.id, source.point), (node.id, Point.START_ACHIEVING)
                yield edge, source.delay


def parent_edges(node: Node, parent: Node) -> Iterator[Edge]:
    """The constraints of a node with its parent, by its role."""
    match node.role:
        case Role.STEP | Role.ACTION:
            yield from _step_edges(node, parent)
        case Role.RECOVERY:
            yield (node.id, Point.END_PLANNING), (parent.id, Point.END_PLANNING)
            yield (node.id, Point.END_ACHIEVING), (parent.id, Point.END_ACHIEVING)
        case Role.GATE if node.origin.gate is not None:
            yield (node.id, Point.END_ACHIEVING), (parent.id, node.origin.gate)
        case _:
            return


def sibling_edges(node: Node, previous: str) -> Iterator[Edge]:
    """The constraints of a new node with its previous sibling, by its flags."""
    flags = flags_of(node)
    if Constraint.SEQ_ACH in flags:
        yield (previous, Point.END_ACHIEVING), (node.id, Point.START_ACHIEVING)
    if Constraint.SEQ_PLANNING in flags and node.is_goal:
        yield (previous, Point.END_PLANNING), (node.id, waiting_point(node, Point.START_PLANNING))


def flags_of(node: Node) -> Constraint:
    """The flags with which a node was sent."""
    return Constraint(node.task.constraints)


def waiting_point(node: Node, point: Point) -> Point:
    """Where to wait for ``point``: under DELAY_PLANNING both starts are one point in time."""
    delayed = node.is_goal and Constraint.DELAY_PLANNING in flags_of(node)
    return Point.START_ACHIEVING if delayed and point is Point.START_PLANNING else point


def check_flags(task: str, flags: Constraint) -> None:
    """Refuse flags that contradict each other.

    Raises:
        RefusedError: PLAN_FIRST stands together with DELAY_PLANNING.
    """
    if Constraint.PLAN_FIRST in flags and Constraint.DELAY_PLANNING in flags:
        why = "PLAN_FIRST and DELAY_PLANNING contradict each other; use one of them"
        raise RefusedError(f"task {task}", why)


def check_cycle(node: Node, ancestors: Iterable[Node]) -> None:
    """Refuse a goal that could never start.

    An ancestor under PLAN_FIRST does not start to achieve before this node is planned, and this
    node under DELAY_PLANNING is not planned before that ancestor achieves.

    Raises:
        RefusedError: The points would wait for each other; it names them.
    """
    if not node.is_goal or Constraint.DELAY_PLANNING not in flags_of(node):
        return
    for ancestor in ancestors:
        if Constraint.PLAN_FIRST in flags_of(ancestor) and _plans(ancestor):
            why = (
                f"{Point.START_PLANNING.value} of {node.task.name} (DELAY_PLANNING) would wait for "
                f"{Point.START_ACHIEVING.value} of {ancestor.task.name} {ancestor.id}, which "
                f"(PLAN_FIRST) waits for it"
            )
            raise RefusedError(f"task {node.id}", why)


def as_recorded(order: Order, nodes: Mapping[str, Node]) -> Order | None:
    """The constraint as it is recorded: what has passed holds nothing, a delay from it ends then.

    So a record says nothing of a task that may be history when it is replayed.
    """
    if order.first is None:
        return order
    source = nodes.get(order.first.task)
    when = source.passed.get(order.first.point, source.ended) if source else None
    if source is not None and when is None:
        return order
    if when is None or not order.delay:
        return None
    return Order(then=order.then, at=when + order.delay)


def _plans(node: Node) -> bool:
    return node.is_goal and Point.END_PLANNING not in node.passed


def _step_edges(node: Node, parent: Node) -> Iterator[Edge]:
    if node.is_goal:
        start = waiting_point(node, Point.START_PLANNING)
        yield (parent.id, Point.START_PLANNING), (node.id, start)
        yield (node.id, Point.END_PLANNING), (parent.id, Point.END_PLANNING)
    yield (parent.id, Point.START_ACHIEVING), (node.id, Point.START_ACHIEVING)
    yield (node.id, Point.END_ACHIEVING), (parent.id, Point.END_ACHIEVING)
