"""Steering tasks from outside: places, constraints, attachments, suspending, monitors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, TypedDict, Unpack

from tca_bus._attaching import AttachmentHandle, sending
from tca_bus._attachments import Attachment
from tca_bus._handle import TaskHandle
from tca_bus._messages import Demon, Goal, Message, Query, TaskMessage
from tca_bus._monitor_spec import Condition, MonitorReport, MonitorSpec
from tca_bus._orders import HasPoints, Moment, Order, TaskRef
from tca_bus._protocol import Constraint, SubmitTask, TaskStatus
from tca_bus._tasks import TaskSender, new_task_id
from tca_bus._tree_queries import (
    Attach,
    ConstrainTasks,
    Detach,
    FindRelative,
    PrepareTask,
    PrioritizeTask,
    Relation,
    RetryTask,
    SuspendTask,
)
from tca_bus._types import answer_adapter
from tca_bus._wire import build

TIMEOUT = 10.0
"""Wall seconds to wait for central."""


class MonitorOptions(TypedDict, total=False):
    """How a monitor tests and fires; see `MonitorSpec` for each.

    ``until`` is a point of a task at which it expires; ``orders`` further constraints, such as on
    the start of its achievement; ``id`` that of the monitor.
    """

    every: float
    duration: float | None
    first_wait: float
    fire_every: int
    most: int | None
    until: Moment | None
    orders: Sequence[Order]
    id: str | None


class Steering(ABC):
    """What a module, or a handler from its node, does with tasks other than sending them.

    Raises:
        RefusedError: From all methods, central will not do it; it says why.
        HandlerFailedError: There is no such task (``unknown_task``).
        NoHandlerError: There is no central.
        TimedOutError: Central did not answer in time.
    """

    async def prepare(self, message: type[TaskMessage[Any]], *, id: str | None = None) -> TaskRef:
        """Make a place for a task, to be sent later under the id that this gives.

        Constraints and attachments may name it at once, and its parent waits for it. It is let
        go with `kill`, or when this module is lost.
        """
        sender = self._tasks
        question = build(
            PrepareTask,
            id=id or new_task_id(sender.core.name),
            name=message.wire_name,
            task_class="goal" if issubclass(message, Goal) else "command",
            sender=sender.core.name,
            parent=self._node,
        )
        status = await sender.ask_central(question, timeout=TIMEOUT)
        return TaskRef(status.id)

    async def constrain(self, *orders: Order) -> int:
        """Add constraints between points, all or none; gives how many hold something back.

        Refused, with the points named, when one has passed already or points would wait for each
        other. A constraint on a task that has ended holds nothing.
        """
        question = build(ConstrainTasks, orders=orders)
        return await self._tasks.ask_central(question, timeout=TIMEOUT)

    async def attach(
        self, what: Attachment, *, to: type[Message] | str | HasPoints
    ) -> AttachmentHandle:
        """Attach a tap, an exception handler or a clean-up.

        Args:
            what: Made by `tap`, `catch` or `clean_up`.
            to: A task, or a message type or its wire name (``*``: every message) for all tasks of
                it, those that are there already among them. The latter ends with this module.
        """
        target = {"to_task": to.id_of()} if isinstance(to, HasPoints) else {"to_message": _name(to)}
        question = build(Attach, what=what, **target)
        attached = await self._tasks.ask_central(question, timeout=TIMEOUT)
        return AttachmentHandle(attached.what, self.detach)

    async def detach(self, attachment: str) -> bool:
        """Take an attachment away by its id; gives whether it was there."""
        question = build(Detach, id=attachment)
        return await self._tasks.ask_central(question, timeout=TIMEOUT)

    async def suspend(self, task: str | HasPoints) -> TaskStatus:
        """Give nothing at or below the task to a handler any more; those that run go on."""
        question = build(SuspendTask, id=_id(task))
        return await self._tasks.ask_central(question, timeout=TIMEOUT)

    async def resume(self, task: str | HasPoints) -> TaskStatus:
        """End a suspension."""
        question = build(SuspendTask, id=_id(task), resume=True)
        return await self._tasks.ask_central(question, timeout=TIMEOUT)

    async def prioritize(self, task: str | HasPoints, priority: int) -> TaskStatus:
        """Change a priority; of a top-level task all that waits below it is put in order again."""
        question = build(PrioritizeTask, id=_id(task), priority=priority)
        return await self._tasks.ask_central(question, timeout=TIMEOUT)

    async def retry(self, task: str | HasPoints) -> TaskStatus:
        """Stop what runs of a living task and below it, and have it handled again."""
        return await self._tasks.ask_central(build(RetryTask, id=_id(task)), timeout=TIMEOUT)

    async def relative(
        self, task: str | HasPoints, relation: Relation | str, *, name: str | None = None
    ) -> TaskStatus | None:
        """Walk the tree; None when no task that is alive stands in that relation."""
        question = build(FindRelative, id=_id(task), relation=relation, name=name)
        return await self._tasks.ask_central(question, timeout=TIMEOUT)

    async def monitor(
        self,
        condition: Query[Condition] | Demon,
        *,
        then: TaskMessage[Any],
        **options: Unpack[MonitorOptions],
    ) -> TaskHandle[MonitorReport]:
        """Watch a condition while this node is being achieved, and do something when it holds.

        A query is polled in the module that serves it; a `Demon` watches by itself. ``then`` is
        sent as a child of the monitor; data of the condition replace its fields of the same name.
        """
        kind = "demon" if isinstance(condition, Demon) else "polling"
        return await self._send_monitor(kind, condition, then, options)

    async def test(
        self,
        condition: Query[Condition],
        *,
        then: TaskMessage[Any],
        **options: Unpack[MonitorOptions],
    ) -> TaskHandle[MonitorReport]:
        """Test a condition once, at its place among the siblings, and act if it holds."""
        return await self._send_monitor("point", condition, then, options)

    async def _send_monitor(
        self,
        kind: str,
        condition: Query[Condition] | Demon,
        then: TaskMessage[Any],
        options: MonitorOptions,
    ) -> TaskHandle[MonitorReport]:
        sender = self._tasks
        flags = Constraint.SEQ_ACH if kind == "point" else Constraint.NONE
        task = build(
            SubmitTask,
            id=options.get("id") or new_task_id(sender.core.name),
            name=condition.wire_name,
            task_class="monitor",
            message_revision=condition.revision,
            data=condition.model_dump(mode="json"),
            sender=sender.core.name,
            parent=self._node,
            constraints=int(flags),
            on_module_lost="resend",
            orders=tuple(options.get("orders", ())),
            monitor=_spec(kind, then, options),
        )
        return await sender.submit(task, answer_adapter(_Reported), timeout=TIMEOUT)

    @property
    @abstractmethod
    def _tasks(self) -> TaskSender:
        """What asks central."""

    @property
    def _node(self) -> str | None:
        """The node below which new ones come; None is the root."""
        return None


class _Reported(Query[MonitorReport]):
    """Gives the type of a monitor's result."""


def _spec(kind: str, then: TaskMessage[Any], options: MonitorOptions) -> MonitorSpec:
    until = options.get("until")
    return MonitorSpec.model_validate(
        {
            "kind": kind,
            "action": sending(then),
            "period": options.get("every", 1.0),
            "duration": options.get("duration"),
            "first_wait": options.get("first_wait", 0.0),
            "fire_every": options.get("fire_every", 1),
            "max_fire": options.get("most"),
            "until": until.ref if until is not None else None,
        }
    )


def _name(message: type[Message] | str) -> str:
    return message if isinstance(message, str) else message.wire_name


def _id(task: str | HasPoints) -> str:
    return task if isinstance(task, str) else task.id_of()
