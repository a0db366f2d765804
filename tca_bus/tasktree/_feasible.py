"""Which constraints can be kept: those that would make points wait for each other are refused."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from tca_bus._errors import RefusedError
from tca_bus._orders import Order, Point, PointRef
from tca_bus._protocol import Constraint, SubmitTask
from tca_bus.tasktree._constraints import (
    Edge,
    delayed_edges,
    own_edges,
    parent_edges,
    sibling_edges,
    waiting_point,
)
from tca_bus.tasktree._node import Node, PointOf

HANDLING_POINTS = frozenset({Point.START_HANDLING, Point.END_HANDLING})

Place = tuple[PointOf, bool]
"""A point on a way, and whether the way to it has a step that is more than passing together."""


@dataclass
class Outlook:
    """The points of the tree as they would wait for each other with some constraints more.

    Raises:
        RefusedError: From each method, points would wait for each other; it names them.
    """

    nodes: Mapping[str, Node]
    after: dict[PointOf, list[PointOf]] = field(default_factory=dict)
    twins: dict[PointOf, list[PointOf]] = field(default_factory=dict)

    def add(self, order: Order) -> None:
        """Add a constraint."""
        if order.first is None:
            return
        what = f"the constraint {order}"
        then = self._waiting(order.then)
        if order.relation == "=":
            self.add_pair(self._waiting(order.first), then, what)
            return
        first = (order.first.task, order.first.point)
        lax = order.relation == "<=" and not order.delay
        self._check(then, first, what, may_be_twins=lax)
        self.after.setdefault(first, []).append(then)

    def add_edge(self, edge: Edge, what: str) -> None:
        """Add a constraint that follows from ``what``."""
        first, then = edge
        self._check(then, first, what, may_be_twins=False)
        self.after.setdefault(first, []).append(then)

    def add_pair(self, one: PointOf, other: PointOf, what: str) -> None:
        """Let two points pass together, as follows from ``what``."""
        for here, there in ((one, other), (other, one)):
            self._check(here, there, what, may_be_twins=True)
        self.twins.setdefault(one, []).append(other)
        self.twins.setdefault(other, []).append(one)

    def _waiting(self, ref: PointRef) -> PointOf:
        return ref.task, waiting_point(self.nodes[ref.task], ref.point)

    def _check(self, start: PointOf, goal: PointOf, what: str, *, may_be_twins: bool) -> None:
        path = self._find_path(start, goal, may_be_twins=may_be_twins)
        if path is not None:
            words = ", then ".join(f"{point.value} of {id}" for id, point in path)
            raise RefusedError(what, f"these points come in order: {words}")

    def _find_path(
        self, start: PointOf, goal: PointOf, *, may_be_twins: bool
    ) -> list[PointOf] | None:
        """A way from a point to one that has to wait for it, perhaps over others; None if none."""
        came_from: dict[Place, Place | None] = {(start, False): None}
        stack: list[Place] = [(start, False)]
        while stack:
            here = stack.pop()
            if here[0] == goal and (here[1] or not may_be_twins):
                return _trace(came_from, here)
            for point, is_more in self._next(here[0]):
                after = (point, here[1] or is_more)
                if after not in came_from:
                    came_from[after] = here
                    stack.append(after)
        return None

    def _next(self, here: PointOf) -> Iterator[Place]:
        node = self.nodes.get(here[0])
        if node is not None:
            yield from ((target, True) for target, _ in node.waiters.get(here[1], ()))
            yield from ((twin, False) for twin in node.twins.get(here[1], ()))
            if here[1] is Point.START_HANDLING:
                yield (here[0], Point.END_HANDLING), True
        yield from ((target, True) for target in self.after.get(here, ()))
        yield from ((twin, False) for twin in self.twins.get(here, ()))


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
        Outlook(nodes).add(order)


def check_together(orders: Iterable[Order], nodes: Mapping[str, Node]) -> None:
    """Refuse constraints that would make points wait for each other when all are made.

    Raises:
        RefusedError: It names the points.
    """
    outlook = Outlook(nodes)
    for order in orders:
        if not _is_past(order, nodes):
            outlook.add(order)


def check_new(task: SubmitTask, previous: str | None, nodes: dict[str, Node], *, root: str) -> None:
    """Refuse a task of which some point could never pass.

    Only one with constraints of its own, in a place that others may wait for, or with
    DELAY_PLANNING can be such a task.

    Raises:
        RefusedError: One of its constraints cannot be kept, or its flags make points wait for
            each other; it names them.
    """
    place = nodes.get(task.id)
    if place is None and not task.orders and not task.constraints & Constraint.DELAY_PLANNING:
        return
    new = _newborn(task, root) if place is None else _filled(place, task)
    view = ChainMap({task.id: new}, nodes)
    outlook = Outlook(view)
    if place is not None and new.twins is not place.twins:
        for twin in place.twins.get(Point.START_PLANNING, ()):
            outlook.add_pair((task.id, Point.START_ACHIEVING), twin, f"task {task.id}")
    for first, then in _edges(new, previous, nodes):
        if first[1] not in view[first[0]].passed and then[1] not in view[then[0]].passed:
            outlook.add_edge((first, then), f"task {task.id}")
    for order in task.orders:
        check_order(order, view)
        if not _is_past(order, view):
            outlook.add(order)


def _edges(new: Node, previous: str | None, nodes: Mapping[str, Node]) -> Iterator[Edge]:
    yield from own_edges(new)
    yield from (edge for edge, _ in delayed_edges(new))
    if new.task.parent is not None:
        yield from parent_edges(new, nodes[new.task.parent])
    if previous is not None:
        ahead = nodes[previous].ahead()
        yield from (edge for edge in sibling_edges(new, previous) if edge[0][1] in ahead)


def _newborn(task: SubmitTask, root: str) -> Node:
    new = Node(task, 0.0, root)
    if not new.is_goal:
        new.passed = dict.fromkeys((Point.START_PLANNING, Point.END_PLANNING), 0.0)
    return new


def _filled(place: Node, task: SubmitTask) -> Node:
    new = replace(place, task=task, prepared=False)
    if waiting_point(new, Point.START_PLANNING) is not Point.START_PLANNING:
        new.twins = {p: twins for p, twins in place.twins.items() if p != Point.START_PLANNING}
    return new


def _is_past(order: Order, nodes: Mapping[str, Node]) -> bool:
    """Whether one of its points has passed, so that it makes nothing wait but for a delay."""
    refs = [ref for ref in (order.first, order.then) if ref is not None]
    return any(ref.point in nodes[ref.task].passed for ref in refs if ref.task in nodes)


def _trace(came_from: Mapping[Place, Place | None], end: Place) -> list[PointOf]:
    path = [end]
    while (before := came_from[path[-1]]) is not None:
        path.append(before)
    return [point for point, _ in path[::-1]]
