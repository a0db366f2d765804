"""What a tree refuses, asked before the event that would bring it."""

from __future__ import annotations

from collections.abc import Iterable

from tca_bus._attachments import Attachment
from tca_bus._errors import NoHandlerError, RefusedError
from tca_bus._orders import Order
from tca_bus._protocol import SubmitTask
from tca_bus.tasktree._admission import (
    ROOT,
    check_attachment,
    check_constraints,
    check_order,
    check_parent,
    check_submission,
)
from tca_bus.tasktree._feasible import check_together
from tca_bus.tasktree._view import View


class Checks(View):
    """Says whether a request can be, in the tree as it is."""

    def check(self, task: SubmitTask) -> None:
        """Refuse a submission that cannot become a node. A repeated one is fine.

        Raises:
            RefusedError: the id is taken by another message, the flags contradict each other,
                the parent takes no children, or the node could never start.
            NoHandlerError: nobody handles it and it may not wait.
        """
        check_submission(task, self._machine)
        if self._is_made(task.id):
            return
        check_constraints(task, self._previous(task), self._machine)
        for what in task.attachments:
            check_attachment(what)
        if not task.wait_for_handler and not self._pools.provides(task.name):
            raise NoHandlerError(task.name, self._pools.names())

    def check_prepare(self, id: str, parent: str | None) -> None:
        """Refuse a place that cannot be made.

        Raises:
            RefusedError: the id stands for the root, or the parent takes no children.
        """
        if id == ROOT:
            raise RefusedError(f"task {ROOT!r}", "that id stands for what is above all tasks")
        if parent is not None and id not in self:
            check_parent(id, parent, self._machine)

    def check_order(self, order: Order) -> None:
        """Refuse a constraint that cannot be kept.

        Raises:
            RefusedError: it names the points.
        """
        check_order(order, self._machine.nodes)

    def check_orders(self, orders: Iterable[Order]) -> None:
        """Refuse constraints of which each could be kept, but not all together.

        Raises:
            RefusedError: it names the points that would wait for each other.
        """
        check_together(orders, self._machine.nodes)

    def check_attachment(self, what: Attachment) -> None:
        """Refuse what cannot be attached.

        Raises:
            RefusedError: it says why.
        """
        check_attachment(what)

    def check_kill(self, id: str) -> None:
        """Refuse to kill what is above all tasks.

        Raises:
            RefusedError: the id is that of the root.
        """
        if id == ROOT:
            raise RefusedError("killing the root", "it ends only with central; name a task")

    def _is_made(self, id: str) -> bool:
        node = self._machine.nodes.get(id)
        return node is not None and not node.prepared

    def _previous(self, task: SubmitTask) -> str | None:
        """The sibling before it that is still there; monitors and taps are passed over."""
        if task.monitor is not None and task.monitor.kind != "point":
            return None
        if task.parent is None:
            previous = self._last_of_sender.get(task.sender)
        else:
            previous = self._machine.nodes[task.parent].last_step
        return previous if previous in self and previous != task.id else None
