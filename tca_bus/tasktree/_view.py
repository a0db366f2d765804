"""The tree to look at: nothing here changes it."""

from __future__ import annotations

from tca_bus._attachments import Attachment, Tap
from tca_bus._orders import Order
from tca_bus._protocol import TaskStatus
from tca_bus.tasktree._events import Attached, Registered
from tca_bus.tasktree._machine import Machine
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._pools import Pools
from tca_bus.tasktree._registry import Registry
from tca_bus.tasktree._waits import AnyOf, waits_of
from tca_bus.tasktree._words import waiting_for


class View:
    """What is in a tree, and how each node stands."""

    def __init__(self) -> None:
        self._pools = Pools()
        self._machine = Machine(self._pools)
        self._registry = Registry()
        self._last_of_sender: dict[str, str] = {}

    def __contains__(self, id: object) -> bool:
        return id in self._machine.nodes

    def __len__(self) -> int:
        return len(self._machine.nodes)

    def status(self, id: str) -> TaskStatus:
        """The status of a node.

        Raises:
            KeyError: there is no such node.
        """
        return self._status(self._machine.nodes[id])

    def statuses(self, id: str | None = None) -> list[TaskStatus]:
        """The node and all below it, or all nodes; parents come before their children.

        Raises:
            KeyError: there is no such node.
        """
        if id is not None and id not in self:
            raise KeyError(id)
        roots = [id] if id is not None else self.roots()
        return [self._status(node) for root in roots for node in self._machine.below(root)]

    def roots(self) -> list[str]:
        """The ids of the top-level tasks, oldest first."""
        return [node.id for node in self._machine.nodes.values() if node.task.parent is None]

    def root_of(self, id: str) -> str:
        """The id of the top-level task above a node; the id itself when it is unknown."""
        node = self._machine.nodes.get(id)
        return id if node is None else node.root

    def holders(self) -> dict[str, str]:
        """The incarnations that are present, have nodes or attached something, with their names."""
        return {**self._registry.owners(), **self._pools.incarnations()}

    def attachments(self) -> list[Registered | Attached]:
        """What is attached to messages and to nodes that are alive."""
        found: list[Registered | Attached] = list(self._registry)
        for node in self._machine.nodes.values():
            whats: list[Attachment] = [*node.taps.values()]
            whats += [*node.catches.values(), *node.clean_ups.values()]
            own = [what for what in whats if what.id not in self._registry]
            found += [Attached(node.created, node.id, what) for what in own]
        return found

    def taps_on(self, message: str) -> tuple[Tap, ...]:
        """The taps on all messages of a name."""
        return self._registry.taps_of(message)

    def holds(self, order: Order) -> bool:
        """Whether a constraint still holds a point back."""
        nodes = self._machine.nodes
        then = nodes.get(order.then.task)
        return then is not None and order.then.point not in then.passed

    def is_missing(self, id: str, number: int) -> bool:
        """Whether the wait for a handler that `WaitForHandler` told of still lasts."""
        return self._pools.is_missing(id, number)

    def is_current(self, id: str, attempt: int) -> bool:
        """Whether a module has this try of the node now."""
        node = self._machine.nodes.get(id)
        return node is not None and node.attempt == attempt and node.is_handling

    def is_awaited(self, id: str, key: str) -> bool:
        """Whether the alarm of the node is still wanted."""
        node = self._machine.nodes.get(id)
        return node is not None and key in node.alarms

    @property
    def pools(self) -> Pools:
        """Who handles what, and who waits for it: to look at, not to change."""
        return self._pools

    def waits(self, id: str) -> list[AnyOf]:
        """What a node waits for, as far as that is certain; see `waits_of`."""
        node = self._machine.nodes.get(id)
        if node is None or self._machine.is_suspended(node):
            return []
        return waits_of(node, self._pools)

    def node(self, id: str) -> Node:
        """The node itself, to look at.

        Raises:
            KeyError: there is no such node.
        """
        return self._machine.nodes[id]

    def _status(self, node: Node) -> TaskStatus:
        suspended = not node.has_ended and self._machine.is_suspended(node)
        words = waiting_for(node, self._machine, self._pools, suspended=suspended)
        return node.status(words, suspended=suspended)
