"""Which points a node waits for: its flags, the implicit constraints, and those that were sent.

Source: TCA's flags as in Simmons (1994), the implicit constraints as TCM has them: planning and
achievement of a node enclose those of its children; a goal is handled from the start of its
planning, a command from the start of its achievement and is planned from birth.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from types import MappingProxyType

from tca_bus._errors import RefusedError
from tca_bus._orders import Order, Point, PointRef
from tca_bus._protocol import Constraint
from tca_bus.tasktree._events import Role
from tca_bus.tasktree._node import Node, PointOf

Edge = tuple[PointOf, PointOf]
"""The first point passes before, or together with, the second."""

HANDLING_POINTS = frozenset({Point.START_HANDLING, Point.END_HANDLING})


def own_edges(node: Node) -> Iterator[Edge]:
    """The constraints of a node between its own points."""
    id = node.id
    yield (id, Point.END_HANDLING), (id, Point.END_ACHIEVING)
    yield (id, Point.START_ACHIEVING), (id, Point.END_ACHIEVING)
    if not node.is_goal:
        yield (id, Point.START_ACHIEVING), (id, Point.START_HANDLING)
        return
    yield (id, Point.START_PLANNING), (id, Point.START_HANDLING)
    yield (id, Point.END_HANDLING), (id, Point.END_PLANNING)
    yield (id, Point.END_PLANNING), (id, Point.END_ACHIEVING)
    if Constraint.DELAY_PLANNING in flags_of(node):
        yield (id, Point.START_ACHIEVING), (id, Point.START_PLANNING)
    else:
        yield (id, Point.START_HANDLING), (id, Point.START_ACHIEVING)
    if Constraint.PLAN_FIRST in flags_of(node):
        yield (id, Point.END_PLANNING), (id, Point.START_ACHIEVING)


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


def check_order(order: Order, nodes: Mapping[str, Node]) -> None:
    """Refuse a constraint that cannot be kept.

    Raises:
        RefusedError: A task is not in the tree, the later point has passed before the earlier
            one, or points would wait for each other; it names the points.
    """
    refs = [ref for ref in (order.first, order.then) if ref is not None]
    for ref in refs:
        if ref.task not in nodes:
            raise RefusedError(f"the constraint {order}", f"task {ref.task} is not in the tree")
        if order.relation == "=" and ref.point in HANDLING_POINTS:
            why = f"{ref} depends on when a handler is free, so it cannot be fixed by '='"
            raise RefusedError(f"the constraint {order}", why)
    first, then = order.first, order.then
    if first is None:
        return
    if order.relation == "=" and nodes[first.task].root != nodes[then.task].root:
        why = "'=' holds between points of one top-level task only"
        raise RefusedError(f"the constraint {order}", why)
    has_passed = [ref.point in nodes[ref.task].passed for ref in refs]
    if order.relation == "=" and has_passed[0] != has_passed[1]:
        passed = first if has_passed[0] else then
        raise RefusedError(f"the constraint {order}", f"the {passed} has passed alone")
    if has_passed[1] and not has_passed[0]:
        raise RefusedError(f"the constraint {order}", f"the {then} has passed already")
    if not any(has_passed):
        _check_path(order, first, then, nodes)


def _check_path(order: Order, first: PointRef, then: PointRef, nodes: Mapping[str, Node]) -> None:
    pairs = [(then, first)] if order.relation != "=" else [(then, first), (first, then)]
    for start, goal in pairs:
        path = find_path(nodes, (start.task, start.point), (goal.task, goal.point))
        if path is not None and not _are_twins(path, nodes, order):
            words = ", then ".join(f"{point.value} of {id}" for id, point in path)
            raise RefusedError(f"the constraint {order}", f"these points come in order: {words}")


def _are_twins(path: list[PointOf], nodes: Mapping[str, Node], order: Order) -> bool:
    """Whether the path only says that the points pass together, which `<=` allows."""
    if order.relation == "<" or order.delay:
        return False
    steps = pairwise(path)
    return all(b in nodes[a[0]].twins.get(a[1], ()) for a, b in steps)


def check_together(orders: Iterable[Order], nodes: Mapping[str, Node]) -> None:
    """Refuse constraints that would make points wait for each other when all are made.

    Raises:
        RefusedError: It names the points.
    """
    added: dict[PointOf, list[PointOf]] = {}
    for order in orders:
        if order.first is None:
            continue
        first = (order.first.task, order.first.point)
        then = (order.then.task, order.then.point)
        path = find_path(nodes, then, first, added)
        if path is not None and order.relation != "=":
            words = ", then ".join(f"{point.value} of {id}" for id, point in path)
            raise RefusedError(f"the constraint {order}", f"these points come in order: {words}")
        added.setdefault(first, []).append(then)


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


def find_path(
    nodes: Mapping[str, Node],
    start: PointOf,
    goal: PointOf,
    added: Mapping[PointOf, list[PointOf]] = MappingProxyType({}),
) -> list[PointOf] | None:
    """A way from a point to one that has to wait for it, perhaps over others; None if none.

    ``added`` are constraints that are not in the tree yet.
    """
    came_from: dict[PointOf, PointOf | None] = {start: None}
    stack = [start]
    while stack:
        here = stack.pop()
        if here == goal:
            return _trace(came_from, here)
        for after in [*_after(nodes, here), *added.get(here, ())]:
            if after not in came_from:
                came_from[after] = here
                stack.append(after)
    return None


def _after(nodes: Mapping[str, Node], here: PointOf) -> Iterator[PointOf]:
    node = nodes.get(here[0])
    if node is not None:
        yield from (target for target, _ in node.waiters.get(here[1], ()))
        yield from node.twins.get(here[1], ())


def _trace(came_from: Mapping[PointOf, PointOf | None], end: PointOf) -> list[PointOf]:
    path = [end]
    while (before := came_from[path[-1]]) is not None:
        path.append(before)
    return path[::-1]


def _plans(node: Node) -> bool:
    return node.is_goal and Point.END_PLANNING not in node.passed


def _step_edges(node: Node, parent: Node) -> Iterator[Edge]:
    if node.is_goal:
        start = waiting_point(node, Point.START_PLANNING)
        yield (parent.id, Point.START_PLANNING), (node.id, start)
        yield (node.id, Point.END_PLANNING), (parent.id, Point.END_PLANNING)
    yield (parent.id, Point.START_ACHIEVING), (node.id, Point.START_ACHIEVING)
    yield (node.id, Point.END_ACHIEVING), (parent.id, Point.END_ACHIEVING)
