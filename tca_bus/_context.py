"""What a handler is given beside its message."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from tca_bus._handle import TaskHandle
from tca_bus._messages import Command, Goal
from tca_bus._protocol import Constraint

if TYPE_CHECKING:
    from tca_bus._module import Module

R = TypeVar("R")


class Context:
    """Where a handled message came from.

    ``sender`` is the name of the sending module, taken from the key; ``id`` that of the request.
    """

    def __init__(self, module: Module, *, sender: str, id: str) -> None:
        self.module = module
        self.sender = sender
        self.id = id


class TaskContext(Context):
    """The node that a handler works on; what it sends from here becomes its children.

    ``id`` is the task's id, ``attempt`` counts from 1 how often it was given to a handler.
    ``seen_failures`` are the children whose failures the handler received itself: they do not
    fail the node.
    """

    def __init__(self, module: Module, *, sender: str, id: str, attempt: int) -> None:
        super().__init__(module, sender=sender, id=id)
        self.attempt = attempt
        self.seen_failures: list[str] = []

    async def expand(
        self,
        goal: Goal[R],
        *,
        id: str | None = None,
        constraints: Constraint = Constraint.SEQ_ACH,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,
    ) -> TaskHandle[R]:
        """Make a goal below this node; see `Module.expand`.

        A handler that may run twice for one node (``attempt`` 2) gives its children ids of its
        own making, so that it meets them again instead of making them twice.
        """
        return await self.module.submit(
            goal,
            id=id,
            constraints=constraints,
            priority=priority,
            wait_for_handler=wait_for_handler,
            timeout=timeout,
            inside=self,
        )

    async def execute(
        self,
        command: Command[R],
        *,
        id: str | None = None,
        constraints: Constraint = Constraint.SEQ_ACH,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,
    ) -> TaskHandle[R]:
        """Make a command below this node; see `Module.execute` and `expand`."""
        return await self.module.submit(
            command,
            id=id,
            constraints=constraints,
            priority=priority,
            wait_for_handler=wait_for_handler,
            timeout=timeout,
            inside=self,
        )

    def saw_failure(self, child: str) -> None:
        """Note that the handler received the failure of a child itself."""
        if child not in self.seen_failures:
            self.seen_failures.append(child)
