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

    def __init__(self, module: Module, *, sender: str, id: str) -> None:  # noqa: A002
        self.module = module
        self.sender = sender
        self.id = id


class TaskContext(Context):
    """The node that a handler works on; what it sends from here becomes its children.

    ``id`` is the task's id, ``attempt`` counts from 1 how often it was given to a handler.
    ``seen_failures`` are the children whose failures the handler received itself.
    """

    def __init__(self, module: Module, *, sender: str, id: str, attempt: int) -> None:  # noqa: A002
        super().__init__(module, sender=sender, id=id)
        self.attempt = attempt
        self.seen_failures: list[str] = []

    async def expand(
        self,
        goal: Goal[R],
        *,
        id: str | None = None,  # noqa: A002
        constraints: Constraint = Constraint.SEQ_ACH,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,  # noqa: ASYNC109
    ) -> TaskHandle[R]:
        """Make a goal below this node; see `Module.expand`."""
        raise NotImplementedError

    async def execute(
        self,
        command: Command[R],
        *,
        id: str | None = None,  # noqa: A002
        constraints: Constraint = Constraint.SEQ_ACH,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,  # noqa: ASYNC109
    ) -> TaskHandle[R]:
        """Make a command below this node; see `Module.execute`."""
        raise NotImplementedError
