"""A task node as its sender holds it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from weakref import WeakSet

from pydantic import TypeAdapter

from tca_bus._errors import KilledError, TaskFailedError, TimedOutError
from tca_bus._failure import Failure
from tca_bus._orders import HasPoints
from tca_bus._protocol import TaskState, TaskStatus
from tca_bus._wire import validate_plain

if TYPE_CHECKING:
    from tca_bus._tasks import TaskSender

R = TypeVar("R")

REFRESH_PERIOD = 2.0
"""Wall seconds after which a waiting handle asks central again: a published state may be lost."""


class TaskHandle(HasPoints, Generic[R]):
    """A goal or command that central has acknowledged.

    ``status`` is the latest state seen. The handle survives restarts of the router, of central
    and of the handling module; one made again with the same id in another process sees the same
    node.
    """

    def __init__(
        self,
        status: TaskStatus,
        sender: TaskSender,
        adapter: TypeAdapter[Any],
        on_failure: Callable[[str], None] | None = None,
    ) -> None:
        self.status = status
        self._sender = sender
        self._adapter = adapter
        self._on_failure = on_failure
        self._changed = asyncio.Event()
        self._is_stale = False
        self.kin: WeakSet[TaskHandle[Any]] | None = None
        """The handles of the task in this module, which stay together while there is one."""

    @property
    def id(self) -> str:
        """The id of the task."""
        return self.status.id

    def id_of(self) -> str:
        """The id of the task."""
        return self.id

    def update(self, status: TaskStatus) -> None:
        """Take a state from central, if it is newer than the one at hand."""
        if status.sequence > self.status.sequence:
            self.status = status
            self._ring()

    def ask_again(self) -> None:
        """Have those who wait ask central: a published state may have been lost."""
        self._is_stale = True
        self._ring()

    def _ring(self) -> None:
        self._changed.set()
        self._changed = asyncio.Event()

    async def result(self, *, timeout: float | None = None) -> R:
        """Wait for the end of the task and give its result.

        Cancelling the wait leaves the task alone.

        Raises:
            TaskFailedError: The task failed; ``failure`` says why.
            KilledError: It was killed.
            TimedOutError: It did not end within ``timeout`` wall seconds; it goes on.
        """
        try:
            async with asyncio.timeout(timeout):
                await self._ended()
        except TimeoutError as error:
            raise TimedOutError(f"task {self.id}", timeout or 0.0) from error
        return self._outcome()

    async def kill(self, reason: str) -> TaskStatus:
        """Ask central to kill the task and all below it; gives the state it is in then."""
        status = await self._sender.kill(self.id, reason=reason)
        self.update(status)
        return status

    async def changed(self) -> TaskStatus:
        """Wait for the next change of the task's state.

        A change that is published while the router is away is seen when central is asked again.
        """
        before = self.status
        while self.status is before:
            await self._next_news()
        return self.status

    async def _ended(self) -> None:
        while not self.status.is_ended:
            await self._next_news()

    async def _next_news(self) -> None:
        try:
            async with asyncio.timeout(REFRESH_PERIOD):
                await self._changed.wait()
        except TimeoutError:
            self._is_stale = True
        if self._is_stale and not self.status.is_ended:
            self._is_stale = False
            await self._sender.refresh(self)

    def _outcome(self) -> R:
        status = self.status
        if status.state == TaskState.ACHIEVED:
            return validate_plain(status.result, self._adapter, status.name)  # type: ignore[no-any-return]
        if self._on_failure is not None:
            self._on_failure(self.id)
        if status.state == TaskState.KILLED:
            raise KilledError(self.id, status.failure.text if status.failure else "no reason given")
        raise TaskFailedError(self.id, status.failure or _unexplained(status))


def _unexplained(status: TaskStatus) -> Failure:
    return Failure(name="unknown", text="no reason given", message=status.name, node=status.id)
