"""Which points a new node waits for: its flags and the implicit constraints.

Source: TCA's flags as in Simmons (1994), the implicit constraints as TCM has them: planning and
achievement of a node enclose those of its children; a goal is handled from the start of its
planning, a command from the start of its achievement and is planned from birth.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from tca_bus._errors import RefusedError
from tca_bus._protocol import Constraint
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._points import Point, PointOf

Edge = tuple[PointOf, PointOf]
"""The first point passes before, or together with, the second."""


def edges(node: Node, parent: Node | None) -> Iterator[Edge]:
    """The constraints of a new node with itself and its parent; None for the root."""
    yield from _own_edges(node)
    if parent is not None:
        yield from _parent_edges(node, parent)


def sibling_edges(node: Node, previous: str) -> Iterator[Edge]:
    """The constraints of a new node with its previous sibling, by its flags."""
    flags = _flags(node)
    if Constraint.SEQ_ACH in flags:
        yield (previous, Point.END_ACHIEVING), (node.id, Point.START_ACHIEVING)
    if Constraint.SEQ_PLANNING in flags and node.is_goal:
        yield (previous, Point.END_PLANNING), (node.id, _start_of_planning(node))


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
    if not node.is_goal or Constraint.DELAY_PLANNING not in _flags(node):
        return
    for ancestor in ancestors:
        if Constraint.PLAN_FIRST in _flags(ancestor) and _plans(ancestor):
            why = (
                f"{Point.START_PLANNING.value} of {node.task.name} (DELAY_PLANNING) would wait for "
                f"{Point.START_ACHIEVING.value} of {ancestor.task.name} {ancestor.id}, which "
                f"(PLAN_FIRST) waits for it"
            )
            raise RefusedError(f"task {node.id}", why)


def _plans(node: Node) -> bool:
    return node.is_goal and Point.END_PLANNING not in node.passed


def _flags(node: Node) -> Constraint:
    return Constraint(node.task.constraints)


def _own_edges(node: Node) -> Iterator[Edge]:
    id = node.id
    yield (id, Point.END_HANDLING), (id, Point.END_ACHIEVING)
    yield (id, Point.START_ACHIEVING), (id, Point.END_ACHIEVING)
    if not node.is_goal:
        yield (id, Point.START_ACHIEVING), (id, Point.START_HANDLING)
        return
    yield (id, Point.START_PLANNING), (id, Point.START_HANDLING)
    yield (id, Point.END_HANDLING), (id, Point.END_PLANNING)
    yield (id, Point.END_PLANNING), (id, Point.END_ACHIEVING)
    if Constraint.DELAY_PLANNING in _flags(node):
        yield (id, Point.START_ACHIEVING), (id, Point.START_PLANNING)
    else:
        yield (id, Point.START_HANDLING), (id, Point.START_ACHIEVING)
    if Constraint.PLAN_FIRST in _flags(node):
        yield (id, Point.END_PLANNING), (id, Point.START_ACHIEVING)


def _parent_edges(node: Node, parent: Node) -> Iterator[Edge]:
    if node.is_goal:
        yield (parent.id, Point.START_PLANNING), (node.id, _start_of_planning(node))
        yield (node.id, Point.END_PLANNING), (parent.id, Point.END_PLANNING)
    yield (parent.id, Point.START_ACHIEVING), (node.id, Point.START_ACHIEVING)
    yield (node.id, Point.END_ACHIEVING), (parent.id, Point.END_ACHIEVING)


def _start_of_planning(node: Node) -> Point:
    """Under DELAY_PLANNING both starts are one point in time: what holds one holds both."""
    delayed = Constraint.DELAY_PLANNING in _flags(node)
    return Point.START_ACHIEVING if delayed else Point.START_PLANNING
