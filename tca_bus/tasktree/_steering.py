"""What is changed of a node from outside: attachments, suspension, priority."""

from __future__ import annotations

from tca_bus._attachments import Catch, CleanUp, Tap
from tca_bus._orders import Point
from tca_bus._protocol import Handling
from tca_bus.tasktree._events import Role
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._recovery import Failing


class Steered(Failing):
    """Lets nodes be attached to, suspended, resumed and put in another order."""

    def is_suspended(self, node: Node) -> bool:
        """Whether the node or one above it is suspended; a clean-up is not by those above."""
        for each in [node, *self.ancestors(node)]:
            if each.suspended:
                return True
            if each.role is Role.CLEAN_UP:
                return False
        return False

    def attach(self, node: Node, what: Tap | Catch | CleanUp) -> None:
        """Attach something to a node; of one id there is one."""
        match what:
            case Tap():
                node.taps[what.id] = what
            case Catch():
                node.catches[what.id] = what
            case CleanUp():
                node.clean_ups[what.id] = what

    def _detach(self, node: Node, attachment: str) -> None:
        node.catches.pop(attachment, None)
        node.clean_ups.pop(attachment, None)
        if node.taps.pop(attachment, None) is None:
            return
        for id in list(node.alive):
            child = self.nodes.get(id)
            if child is not None and child.origin.attachment == attachment:
                self._later(self._kill, child, "its tap was removed")

    def _suspend(self, node: Node) -> None:
        node.suspended = True
        for each in self.below(node.id):
            self.touched[each.id] = None
            self.pools.forget(each.id)

    def _resume(self, node: Node) -> None:
        node.suspended = False
        for each in self.below(node.id):
            self.touched[each.id] = None
            self._later(self._try_ready, each)

    def _prioritize(self, node: Node, priority: int) -> None:
        """Put what waits in order again, by age too: of a top-level task, all that is below it."""
        node.priority = priority
        waiting = self.below(node.id) if node.id == node.root else [node]
        for each in waiting:
            self.pools.reprioritise(each.id, self._rank(each))

    def _look_again(self, node: Node) -> None:
        """What waits for its handler may have to wait for something else now."""
        if node.handling is Handling.UNHANDLED:
            self.pools.forget(node.id)
            self._later(self._try_ready, node)

    def _try_ready(self, node: Node) -> None:
        if not node.is_ready or self.is_suspended(node):
            return
        if self._is_gated(node, Point.START_HANDLING):
            return
        self.touched[node.id] = None
        name, rank, sender = node.task.name, self._rank(node), node.task.sender
        self.pools.wait(node.id, name, rank, only=node.only, sender=sender)

    def _rank(self, node: Node) -> tuple[int, int]:
        """The priority of the whole task, then that of the node in it."""
        top = self.nodes[node.root]
        return top.priority, node.priority if node is not top else 0
