"""The contexts of one module's handlers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tca_bus._attachments import Caught
from tca_bus._clock import Clock
from tca_bus._context import Context
from tca_bus._protocol import HandleTask
from tca_bus._task_context import ExceptionContext, MonitorContext, TaskContext

if TYPE_CHECKING:
    from tca_bus._module import Module
    from tca_bus._monitoring import Firing


@dataclass(frozen=True)
class ModuleContexts:
    """Makes what the handlers of a module are given beside their messages."""

    module: Module

    def plain(self, *, sender: str, id: str) -> Context:
        """For queries, one-way messages, and conditions that are tested."""
        return Context(self.module, sender=sender, id=id)

    def task(self, task: HandleTask) -> TaskContext:
        """For goals, commands and exceptions."""
        facts = {"sender": task.sender, "id": task.id}
        if task.task_class == "exception":
            told = Caught.model_validate(task.data)
            return ExceptionContext(self.module, **facts, attempt=task.attempt, told=told)
        return TaskContext(self.module, **facts, attempt=task.attempt, retries=task.retries)

    def monitor(self, task: HandleTask, firing: Firing) -> MonitorContext:
        """For demons."""
        return MonitorContext(self.module, sender=task.sender, id=task.id, firing=firing)

    def clock(self) -> Clock:
        """The clock of the module."""
        return self.module.clock
