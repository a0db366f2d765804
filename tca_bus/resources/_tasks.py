"""What holds need to know of the task tree."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Protocol

from tca_bus.resources._waits import Clause


class Tasks(Protocol):
    """A look into the task tree."""

    def attending(self, resource: str) -> Collection[str]:
        """The tasks that have a place in a handlers' resource, by its full name."""
        ...

    def is_handled(self, task: str) -> bool:
        """Whether the handler of a task has ended, and the task has not."""
        ...

    def awaited(self, task: str) -> Collection[str]:
        """The tasks whose end the handler of a task waits for."""
        ...

    def awaited_with(self, hold: str) -> Collection[str]:
        """The tasks whose end is waited for by whoever has a hold."""
        ...

    def clauses(self, task: str) -> Sequence[Clause]:
        """What a task waits for that is not being handled."""
        ...


class NoTasks:
    """An empty tree."""

    def attending(self, resource: str) -> Collection[str]:
        """Nothing."""
        del resource
        return ()

    def is_handled(self, task: str) -> bool:
        """It is not."""
        del task
        return False

    def awaited(self, task: str) -> Collection[str]:
        """Nothing."""
        del task
        return ()

    def awaited_with(self, hold: str) -> Collection[str]:
        """Nothing."""
        del hold
        return ()

    def clauses(self, task: str) -> Sequence[Clause]:
        """Nothing."""
        del task
        return ()
