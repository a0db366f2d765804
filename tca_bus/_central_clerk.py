"""Asks, for what a module wants from central, whether the policy lets it.

A router sees who asks central, but not what about; so this is for central alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from tca_bus._errors import RefusedError
from tca_bus._permissions import Permissions
from tca_bus._policy import ANYBODY
from tca_bus._protocol import SubmitTask, TaskStatus
from tca_bus._rights import Right

if TYPE_CHECKING:
    from tca_bus._central import Central


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
        self.permissions.check_task_size(task.sender, task.name, task.data)
        parent = self._central.status(task.parent) if task.parent is not None else None
        if parent is not None and parent.handler != task.sender:
            self.check(task.sender, Right.EDIT, parent.id, parent)

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
