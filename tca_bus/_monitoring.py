"""The testing side of monitors: in the module that serves the condition."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from pydantic import TypeAdapter, ValidationError

from tca_bus._clock import Clock
from tca_bus._context import Context
from tca_bus._errors import TaskError
from tca_bus._handlers import Handler
from tca_bus._messages import Message
from tca_bus._monitor_spec import Condition, MonitorSpec
from tca_bus._problems import problems_of
from tca_bus._protocol import HandleTask
from tca_bus._task_context import MonitorContext
from tca_bus._tasks import OUT_OF_REACH, TaskSender
from tca_bus._tree_queries import Trigger

logger = logging.getLogger(__name__)

TRIGGER_PATIENCE = 60.0
"""Wall seconds of one try to tell central of a satisfied test; it is told again until it has it."""

_ANSWER: TypeAdapter[Condition] = TypeAdapter(Condition)


class MakeContext(Protocol):
    """Makes the context with which a condition is tested."""

    def __call__(self, *, sender: str, id: str) -> Context:
        """Make it."""
        ...


@dataclass
class Firing:
    """Tells central of each satisfied test, in order, until it has it."""

    sender: TaskSender
    task: HandleTask
    number: int = 0

    async def fire(self, data: dict[str, Any]) -> bool:
        """Tell of one; gives whether the monitor goes on."""
        self.number += 1
        told = Trigger(id=self.task.id, attempt=self.task.attempt, number=self.number, data=data)
        while True:
            try:
                return await self.sender.ask_central(told, timeout=TRIGGER_PATIENCE)
            except OUT_OF_REACH as error:
                logger.warning("monitor %s is not heard yet: %s", self.task.id, error)


@dataclass
class MonitorRun:
    """One monitor at work in this module."""

    task: HandleTask
    spec: MonitorSpec
    message: Message
    handler: Handler
    firing: Firing
    context: MakeContext
    demon: Callable[[Firing], MonitorContext]
    clock: Callable[[], Clock]

    async def run(self) -> Any:
        """Test until it is over; gives what the handler of a point monitor or demon said."""
        if self.spec.kind == "demon":
            await self._watch()
            return None
        if self.spec.kind == "point":
            return (await self._test()).model_dump(mode="json")
        await self._poll()
        return None

    async def _watch(self) -> None:
        """Let a demon watch, for at most the monitor's duration."""
        await self._wait_first()
        context = self.demon(self.firing)
        if self.spec.duration is None:
            await self.handler.call(self.message, context)
            return
        try:
            async with self.clock().timeout(self.spec.duration):
                await self.handler.call(self.message, context)
        except TimeoutError:
            return

    async def _poll(self) -> None:
        await self._wait_first()
        begun = self.clock().now()
        while True:
            told = await self._test()
            if told.satisfied and not await self.firing.fire(told.data):
                return
            wake = self.clock().now() + self.spec.period
            if self.spec.duration is not None and wake > begun + self.spec.duration:
                await self.clock().sleep_until(begun + self.spec.duration)
                return
            await self.clock().sleep_until(wake)

    async def _wait_first(self) -> None:
        if self.spec.first_wait:
            await self.clock().sleep(self.spec.first_wait)

    async def _test(self) -> Condition:
        """Ask the condition once; a plain bool will do as its answer."""
        context = self.context(sender=self.task.sender, id=self.task.id)
        value = await self.handler.call(self.message, context)
        if isinstance(value, bool):
            return Condition(satisfied=value)
        try:
            return _ANSWER.validate_python(value)
        except ValidationError as error:
            text = f"condition: {'; '.join(problems_of(error))}"
            raise TaskError("invalid_answer", text) from error
