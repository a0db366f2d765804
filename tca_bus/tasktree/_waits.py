"""Which others have to move before a node does: a cautious view, for finding rings."""

from __future__ import annotations

from tca_bus._orders import Point
from tca_bus._protocol import Handling
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._pools import Pools

AnyOf = tuple[set[str], set[str]]
"""Nodes and holds: one of them has to move."""

_STARTS = (Point.START_HANDLING, Point.START_PLANNING, Point.START_ACHIEVING)


def waits_of(node: Node, pools: Pools) -> list[AnyOf]:
    """What a node waits for, all of which has to come; nothing while its handler runs.

    Where the tree does not know better it takes the node for one that may move.
    """
    if not node.is_alive or node.is_handling or node.restarting or node.failing or node.alarms:
        return []
    if node.handling is Handling.HANDLED:
        return [(set(node.alive), set())] if node.alive else []
    blockers = pools.blockers(node.id)
    if blockers is not None:
        return [blockers] if any(blockers) else []
    sources = [source for start in _STARTS for source in node.open.get(start, ())]
    before = {source.id for source in sources if source.id and source.id != node.id}
    return [({id}, set()) for id in sorted(before)]
