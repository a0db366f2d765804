"""The queries by which modules steer the task tree: constraints, attachments, suspending."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tca_bus._attachments import Attachment
from tca_bus._central_clerk import Clerk, check_sender
from tca_bus._central_past import UNKNOWN_TASK, find_ended, unknown_task, without_past
from tca_bus._context import Context
from tca_bus._errors import RefusedError, TaskError
from tca_bus._module import Module
from tca_bus._orders import Order
from tca_bus._protocol import TaskStatus
from tca_bus._rights import Right
from tca_bus._tree_queries import (
    Attach,
    Attached,
    ConstrainTasks,
    Detach,
    FindRelative,
    ListAttachments,
    PrepareTask,
    PrioritizeTask,
    RetryTask,
    SuspendTask,
    Trigger,
)
from tca_bus.tasktree import Attached as AttachedTo
from tca_bus.tasktree import (
    Constrained,
    Deregistered,
    Detached,
    Prepared,
    Prioritized,
    Registered,
    Resumed,
    Retried,
    Suspended,
    Triggered,
    find_relative,
)

if TYPE_CHECKING:
    from tca_bus._central import Central
    from tca_bus.tasktree import Event


class SteeringDesk:
    """The handlers of the queries that change what is in the tree, or look at it."""

    def __init__(self, central: Central) -> None:
        self._central = central
        self._clerk = Clerk(central)

    def serve(self, module: Module) -> None:
        """Register the handlers."""
        module.serve(PrepareTask, self.prepare)
        module.serve(ConstrainTasks, self.constrain)
        module.serve(SuspendTask, self.suspend)
        module.serve(PrioritizeTask, self.prioritize)
        module.serve(RetryTask, self.retry)
        module.serve(Attach, self.attach)
        module.serve(Detach, self.detach)
        module.serve(ListAttachments, self.attachments)
        module.serve(FindRelative, self.relative)
        module.serve(Trigger, self.trigger)

    async def prepare(self, order: PrepareTask, context: Context) -> TaskStatus:
        """Make a place for a task."""
        central = self._central
        await central.ready.wait()
        check_sender(order.id, order.sender, context.sender)
        self._clerk.check_prepare(order)
        central.tree.check_prepare(order.id, order.parent)
        facts = (order.id, order.name, order.task_class, order.sender, order.parent)
        await central.happen(Prepared(central.now(), *facts))
        return self._status(order.id)

    async def constrain(self, question: ConstrainTasks, context: Context) -> int:
        """Add constraints, all or none."""
        central = self._central
        await central.ready.wait()
        self._clerk.check_orders(context.sender, question.orders)
        effective = await without_past(central, question.orders)
        self._check_together(effective)
        for order in effective:
            kept = central.happen(Constrained(central.now(), order))
        if effective:
            await kept
        return sum(central.tree.holds(order) for order in effective)

    async def suspend(self, order: SuspendTask, context: Context) -> TaskStatus:
        """Suspend a task or resume it."""
        await self._check(context, Right.SUSPEND, order.id)
        kind = Resumed if order.resume else Suspended
        return await self._change(order.id, kind(self._central.now(), order.id))

    async def prioritize(self, order: PrioritizeTask, context: Context) -> TaskStatus:
        """Change a priority."""
        await self._check(context, Right.PRIORITISE, order.id)
        change = Prioritized(self._central.now(), order.id, order.priority)
        return await self._change(order.id, change)

    async def retry(self, order: RetryTask, context: Context) -> TaskStatus:
        """Have a task handled again."""
        await self._check(context, Right.EDIT, order.id)
        return await self._change(order.id, Retried(self._central.now(), order.id))

    async def attach(self, question: Attach, context: Context) -> Attached:
        """Attach something to a task or to a message."""
        central = self._central
        await central.ready.wait()
        self._clerk.check_attach(context.sender, question)
        what = self._owned(question.what, context)
        central.tree.check_attachment(what)
        if (question.to_task is None) == (question.to_message is None):
            why = "it needs either a task or a message to be attached to"
            raise RefusedError(f"the attachment {what.id}", why)
        if question.to_task is not None:
            await self._alive(question.to_task)
            await central.happen(AttachedTo(central.now(), question.to_task, what))
        elif what.kind == "clean_up":
            why = "a clean-up is attached to a task, not to a message"
            raise RefusedError(f"the attachment {what.id}", why)
        else:
            await central.happen(Registered(central.now(), question.to_message or "", what))
        return Attached(to_task=question.to_task, to_message=question.to_message, what=what)

    async def detach(self, question: Detach, context: Context) -> bool:
        """Take an attachment away."""
        central = self._central
        await central.ready.wait()
        for entry in central.tree.attachments():
            if entry.what.id == question.id:
                self._clerk.check_detach(context.sender, entry)
                if isinstance(entry, Registered):
                    await central.happen(Deregistered(central.now(), question.id))
                else:
                    await central.happen(Detached(central.now(), entry.id, question.id))
                return True
        return False

    async def attachments(self, _: ListAttachments, context: Context) -> list[Attached]:
        """What is attached to messages, and to living tasks that the asker may watch."""
        await self._central.ready.wait()
        return [
            Attached(to_task=None, to_message=entry.message, what=entry.what)
            if isinstance(entry, Registered)
            else Attached(to_task=entry.id, to_message=None, what=entry.what)
            for entry in self._central.tree.attachments()
            if isinstance(entry, Registered) or self._clerk.may_see(context.sender, entry.id)
        ]

    async def relative(self, question: FindRelative, context: Context) -> TaskStatus | None:
        """Walk the tree."""
        await self._alive(question.id)
        tree = self._central.tree
        found = find_relative(tree, question.id, question.relation, question.name)
        if found is None:
            return None
        self._clerk.check_watch(context.sender, tree.status(found))
        return tree.status(found)

    async def trigger(self, report: Trigger, context: Context) -> bool:
        """A monitor's condition is satisfied."""
        central = self._central
        await central.ready.wait()
        if not central.tree.is_current(report.id, report.attempt):
            return False
        node = central.tree.node(report.id)
        if node.handler != context.sender:
            why = f"module {node.handler!r} tests it, not {context.sender!r}"
            raise RefusedError(f"the firing of monitor {report.id}", why)
        facts = (report.id, report.attempt, report.number, report.data)
        await central.happen(Triggered(central.now(), *facts))
        alive = central.tree.is_current(report.id, report.attempt)
        return alive and node.watch is not None and not node.watch.expired

    async def _check(self, context: Context, right: Right, id: str) -> None:
        await self._central.ready.wait()
        self._clerk.check(context.sender, right, id)

    async def _change(self, id: str, event: Event) -> TaskStatus:
        await self._alive(id)
        await self._central.happen(event)
        return self._status(id)

    async def _alive(self, id: str) -> None:
        """Refuse what is about a task that is not in the tree."""
        central = self._central
        await central.ready.wait()
        if id in central.tree:
            return
        ended = await find_ended(central, id)
        if ended is not None:
            raise RefusedError(f"task {id}", f"it is {ended.state} already")
        raise unknown_task(central, id)

    def _status(self, id: str) -> TaskStatus:
        status = self._central.status(id)
        if status is None:
            raise TaskError(UNKNOWN_TASK, f"task {id!r} is gone")
        return status

    def _check_together(self, orders: list[Order]) -> None:
        """Refuse all when one cannot be kept.

        The orders of one request are checked against the tree as it is, then against each other
        as they are made: a cycle among them is found before the last one is.
        """
        for order in orders:
            self._central.tree.check_order(order)
        self._central.tree.check_orders(orders)

    def _owned(self, what: Attachment, context: Context) -> Attachment:
        """The attachment with whose it is, as the bus says and not as it says itself."""
        if what.kind == "clean_up":
            return what
        present = self._central.module.modules()
        own = [module for module in present if module.name == context.sender]
        incarnation = max((module.incarnation for module in own), default="")
        return what.model_copy(update={"owner": context.sender, "incarnation": incarnation})
