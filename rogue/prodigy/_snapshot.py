"""A search as it stands at one moment, for drawing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from rogue.prodigy._events import NodeKind
from rogue.prodigy._nodes import Node


class NodeState(StrEnum):
    """What has become of a node."""

    OPEN = "open"
    """Not visited yet, or with something left to try."""
    CLOSED = "closed"
    """Everything it offers was tried, or it was given up for another branch."""
    FAILED = "failed"
    """It failed, and says why."""
    APPLIED = "applied"
    """An operator applied on the path that the search is on."""
    EXECUTED = "executed"
    """Its action was executed."""


@dataclass(frozen=True, slots=True)
class SnapshotNode:
    """A node as it was when the snapshot was taken.

    Attributes:
        number: The n in ``n18``.
        kind: What it decides.
        text: What is printed behind the number, ``<GOTO-PICKUP-LOC MITCHELL R-5303>``.
        parent: Number of the parent in the search tree, 0 for a root.
        depth: Depth in the search tree; the root n1 has 1.
        level: Depth in the goal tree, the indentation.
        state: What has become of it.
        decided_by: The control rule that chose it, or PRODIGY's default (``first``, ``free to
            go``, ...); empty where there was no choice.
        failure: Why it failed, empty if it did not.
        needed_by: For a goal, the numbers of the binding nodes that need it, newest first.
        serves: For operators, bindings and applied operators, the number of the goal node that
            they serve, else 0.
        applies: For an applied operator, the number of its binding node, else 0.
    """

    number: int
    kind: NodeKind
    text: str
    parent: int
    depth: int
    level: int
    state: NodeState
    decided_by: str = ""
    failure: str = ""
    needed_by: tuple[int, ...] = ()
    serves: int = 0
    applies: int = 0


@dataclass(frozen=True, slots=True)
class TreeSnapshot:
    """The search tree at one moment.

    Attributes:
        nodes: By number. Numbers may be missing where old history was let go.
        current: Number of the node that the search is at.
        path: Numbers of the nodes from the oldest kept ancestor down to ``current``.
        barrier: Number of the newest node that cannot be undone, a root or an executed step.
    """

    nodes: tuple[SnapshotNode, ...]
    current: int
    path: tuple[int, ...]
    barrier: int


def take_snapshot(nodes: Iterable[Node], current: Node, barrier: Node) -> TreeSnapshot:
    """Return ``nodes`` as frozen values; ``current`` is the node that the search is at."""
    path = _path(current)
    frozen = tuple(_frozen(node, path) for node in nodes)
    return TreeSnapshot(frozen, current.number, tuple(path), barrier.number)


def _path(node: Node | None) -> dict[int, None]:
    numbers: list[int] = []
    while node is not None:
        numbers.append(node.number)
        node = node.parent
    return dict.fromkeys(reversed(numbers))


def _frozen(node: Node, path: dict[int, None]) -> SnapshotNode:
    goal_node = node.binding.goal_node if node.binding is not None else node.goal_node
    return SnapshotNode(
        number=node.number,
        kind=node.kind,
        text=node.text(),
        parent=node.parent.number if node.parent is not None else 0,
        depth=node.depth,
        level=node.level,
        state=_state(node, on_path=node.number in path),
        decided_by=node.decided_by,
        failure=node.failure,
        needed_by=tuple(consumer.number for consumer in node.needed_by),
        serves=goal_node.number if goal_node is not None else 0,
        applies=node.binding.number if node.binding is not None else 0,
    )


def _state(node: Node, *, on_path: bool) -> NodeState:
    if node.executed:
        return NodeState.EXECUTED
    if node.failure:
        return NodeState.FAILED
    if on_path and node.kind is NodeKind.APPLIED and node.binding is not None:
        return NodeState.APPLIED
    return NodeState.CLOSED if node.closed else NodeState.OPEN
