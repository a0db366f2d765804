"""What a handler of a task is given beside its message."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar, Unpack

from tca_bus._attachments import Caught, Resolution
from tca_bus._context import Context
from tca_bus._failure import Failure
from tca_bus._handle import TaskHandle
from tca_bus._messages import Command, Goal
from tca_bus._orders import HasPoints, TaskRef
from tca_bus._sending import SendOptions
from tca_bus._steering import Steering
from tca_bus._tasks import TaskSender

if TYPE_CHECKING:
    from tca_bus._module import Module

R = TypeVar("R")


class TaskContext(Context, Steering, HasPoints):
    """The node that a handler works on; what it sends from here becomes its children.

    ``id`` is the task's id, ``attempt`` counts from 1 how often it was given to a handler, and
    ``retries`` how often an exception handler or a person had it tried again. ``seen_failures``
    are the children whose failures the handler received itself: they do not fail the node.
    """

    def __init__(
        self, module: Module, *, sender: str, id: str, attempt: int, retries: int = 0
    ) -> None:
        super().__init__(module, sender=sender, id=id)
        self.attempt = attempt
        self.retries = retries
        self.seen_failures: list[str] = []
        self.is_postponed = False

    def id_of(self) -> str:
        """The id of the task."""
        return self.id

    async def expand(self, goal: Goal[R], **options: Unpack[SendOptions]) -> TaskHandle[R]:
        """Make a goal below this node; see `Module.expand`.

        A handler that may run twice for one node (``attempt`` 2) gives its children ids of its
        own making, so that it meets them again instead of making them twice.
        """
        return await self.module.submit(goal, inside=self, **options)

    async def execute(self, command: Command[R], **options: Unpack[SendOptions]) -> TaskHandle[R]:
        """Make a command below this node; see `Module.execute` and `expand`."""
        return await self.module.submit(command, inside=self, **options)

    def postpone(self) -> None:
        """Leave the answer for later: the task goes on after the handler has returned.

        It ends with `Module.answer` or `Module.answer_failure`, called from anywhere in this
        module, and keeps its place in the handler's capacity until then.
        """
        self.is_postponed = True

    def saw_failure(self, child: str) -> None:
        """Note that the handler received the failure of a child itself."""
        if child not in self.seen_failures:
            self.seen_failures.append(child)

    @property
    def _tasks(self) -> TaskSender:
        return self.module._tasks  # noqa: SLF001

    @property
    def _node(self) -> str | None:
        return self.id


class ExceptionContext(TaskContext):
    """A failure that an exception handler is to deal with.

    ``failure`` is what happened, ``failed`` the task that failed, ``on`` the task on which the
    handler was found; ``caught`` has more. A handler that returns has repaired the failure: the
    failed task counts as done, with what it returned as its result. What it sends becomes a part
    of the failed task. One that raises replaces the failure by its own.
    """

    def __init__(self, module: Module, *, sender: str, id: str, attempt: int, told: Caught) -> None:
        super().__init__(module, sender=sender, id=id, attempt=attempt)
        self.caught = told
        self.failure = Failure.model_validate(told.failure)
        self.failed = TaskRef(told.failed)
        self.on = TaskRef(told.context)
        self.resolution = Resolution()

    def retry_failed(self, *, most: int = 3) -> None:
        """When the handler returns, run the failed task again, at most ``most`` times in all.

        After that many the search for a handler goes on, as after `bypass`.
        """
        self.resolution = Resolution(action="retry", task=self.failed.id, most=most)

    def retry_context(self, *, most: int = 3) -> None:
        """When the handler returns, run the task again on which the handler was found."""
        self.resolution = Resolution(action="retry", task=self.on.id, most=most)

    def bypass(self) -> None:
        """When the handler returns, let the search for another go on: this is not for it."""
        self.resolution = Resolution(action="bypass")


class MonitorContext(Context):
    """A demon's monitor: the handler watches, and fires when it sees what it looks for."""

    def __init__(self, module: Module, *, sender: str, id: str, firing: Any) -> None:
        super().__init__(module, sender=sender, id=id)
        self._firing = firing

    async def fire(self, **data: Any) -> bool:
        """Say that the condition holds; gives whether the monitor goes on.

        ``data`` replace the fields of the action that have the same names.
        """
        goes_on: bool = await self._firing.fire(data)
        return goes_on
