"""A task node as its sender holds it."""

from __future__ import annotations

from typing import Generic, TypeVar

from tca_bus._protocol import TaskStatus

R = TypeVar("R")


class TaskHandle(Generic[R]):
    """A goal or command that central has acknowledged."""

    def __init__(self, status: TaskStatus) -> None:
        self.status = status

    @property
    def id(self) -> str:
        """The id of the task."""
        return self.status.id

    async def result(self, *, timeout: float | None = None) -> R:  # noqa: ASYNC109
        """Wait for the end of the task and give its result."""
        raise NotImplementedError

    async def kill(self, reason: str) -> TaskStatus:
        """Ask central to kill the task and all below it."""
        raise NotImplementedError
