"""Asks, for what a module wants from central, whether the policy lets it.

A router sees who asks central, but not what about; so this is for central alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from tca_bus._attachments import Attachment, Catch, CleanUp, Tap
from tca_bus._errors import RefusedError
from tca_bus._orders import Order
from tca_bus._permissions import Permissions
from tca_bus._policy import ANYBODY
from tca_bus._protocol import SubmitTask, TaskStatus
from tca_bus._rights import Right
from tca_bus._tree_queries import Attach, PrepareTask
from tca_bus.tasktree import Attached, Registered

if TYPE_CHECKING:
    from tca_bus._central import Central


def right_to_send(task: SubmitTask) -> Right:
    """The right that a task needs of its sender."""
    return Right.MONITOR if task.task_class == "monitor" else Right.SEND


def check_sender(id: str, named: str, sender: str) -> None:
    """Let nobody send a task in the name of another.

    Raises:
        RefusedError: The sender that the task names is not the one that it comes from.
    """
    if named != sender:
        why = f"it names {named!r} as its sender but comes from {sender!r}"
        raise RefusedError(f"task {id}", why)


class Clerk:
    """Knows which task a request is about: its message, its sender and who handles it."""

    def __init__(self, central: Central) -> None:
        self._central = central

    @property
    def permissions(self) -> Permissions:
        """The policy that is in force."""
        return self._central.permissions

    @property
    def is_needed(self) -> bool:
        """Whether there is a policy at all."""
        return self.permissions.policy is not None

    def check_submit(self, task: SubmitTask) -> None:
        """Refuse a task that its sender may not send, or not there, or not so big.

        Below a node only its handler and its sender make children, and who may edit it.

        Raises:
            RefusedError: It may not.
        """
        if not self.is_needed:
            return
        self.permissions.check_task_size(
            task.sender, task.name, task.data, right=right_to_send(task)
        )
        self.check_parent(task.sender, task.parent)
        for what in task.attachments:
            self._check_sent_for(task.sender, what)
        if task.monitor is not None:
            self.permissions.check(task.sender, Right.SEND, task.monitor.action.name)
        self.check_orders(task.sender, task.orders, own=task.id)

    def check_prepare(self, order: PrepareTask) -> None:
        """Refuse a place for a task that its sender may not send, or not there.

        Raises:
            RefusedError: It may not.
        """
        self.permissions.check(order.sender, Right.SEND, order.name)
        self.check_parent(order.sender, order.parent)

    def check_parent(self, sender: str, id: str | None) -> None:
        """Refuse a child below a task that ``sender`` neither handles nor sent nor may edit.

        Raises:
            RefusedError: It may not.
        """
        if not self.is_needed or id is None:
            return
        parent = self._central.status(id)
        if parent is not None and parent.handler != sender:
            self.check(sender, Right.EDIT, id, parent)

    def check_orders(self, sender: str, orders: Iterable[Order], *, own: str = "") -> None:
        """Refuse constraints that hold tasks, other than ``own``, that ``sender`` may not edit.

        Raises:
            RefusedError: It may not.
        """
        if not self.is_needed:
            return
        for order in orders:
            held = [order.then.task]
            if order.first is not None and order.relation == "=":
                held.append(order.first.task)
            for id in held:
                if id != own:
                    self.check(sender, Right.EDIT, id)

    def check_attach(self, sender: str, question: Attach) -> None:
        """Refuse what ``sender`` may not attach there, or what it may not have sent.

        Raises:
            RefusedError: It may not.
        """
        if not self.is_needed:
            return
        self._check_sent_for(sender, question.what)
        right = Right.TAP if question.what.kind == "tap" else Right.EDIT
        if question.to_task is not None:
            self.check(sender, right, question.to_task)
        elif question.to_message is not None:
            self.permissions.check(sender, right, question.to_message)

    def check_detach(self, sender: str, entry: Registered | Attached) -> None:
        """Refuse to take away what is neither of ``sender`` nor on what it may edit.

        Raises:
            RefusedError: It may not.
        """
        if not self.is_needed or getattr(entry.what, "owner", None) == sender:
            return
        if isinstance(entry, Registered):
            self.permissions.check(sender, Right.EDIT, entry.message)
        else:
            self.check(sender, Right.EDIT, entry.id)

    def may_see(self, sender: str, id: str) -> bool:
        """Whether ``sender`` may be told of a task that is alive."""
        status = self._central.status(id)
        return not self.is_needed or (status is not None and self._may_watch(sender, status))

    def _check_sent_for(self, sender: str, what: Attachment) -> None:
        """Central sends it for ``sender``: that gives nobody a right that it has not got."""
        match what:
            case Tap(listener=sending) | CleanUp(sending=sending):
                self.permissions.check(sender, Right.SEND, sending.name)
            case Catch(handler=name):
                self.permissions.check(sender, Right.SEND, name)

    def check(self, sender: str, right: Right, id: str, ended: TaskStatus | None = None) -> None:
        """Refuse what ``sender`` may not do with a task, alive or ended.

        A task that is not known yet belongs to who its id begins with, as ids usually do.

        Raises:
            RefusedError: It may not.
        """
        if not self.is_needed:
            return
        status = ended or self._central.status(id)
        if status is not None:
            self.permissions.check(sender, right, status.name, owner=status.sender)
        elif not id.startswith(f"{sender}-"):
            self.permissions.check(sender, right, f"task {id}", owner="somebody")

    def check_watch(self, sender: str, status: TaskStatus) -> None:
        """Refuse to tell of a task that ``sender`` neither sent nor handles nor may watch.

        Raises:
            RefusedError: It may not be told.
        """
        if sender != status.handler:
            self.permissions.check(sender, Right.WATCH, status.sender)

    def check_watch_all(self, sender: str) -> None:
        """Refuse to tell of all tasks.

        Raises:
            RefusedError: ``sender`` may not watch all senders.
        """
        if not self.permissions.may(sender, Right.WATCH, ANYBODY):
            why = f"module {sender!r} may not watch the tasks of all modules; name one task"
            raise RefusedError("the whole history", why)

    def watchable(self, sender: str, found: Iterable[TaskStatus]) -> list[TaskStatus]:
        """Those of the tasks that ``sender`` may be told of."""
        return [status for status in found if self._may_watch(sender, status)]

    def _may_watch(self, sender: str, status: TaskStatus) -> bool:
        may = self.permissions.may(sender, Right.WATCH, status.sender)
        return may or sender == status.handler
