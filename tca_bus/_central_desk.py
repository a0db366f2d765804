"""The queries that central answers."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from tca_bus._central_clerk import Clerk, check_sender
from tca_bus._central_past import find_ended, unknown_task, without_past
from tca_bus._context import Context
from tca_bus._errors import RefusedError
from tca_bus._module import Module
from tca_bus._protocol import (
    FindTask,
    KillTask,
    ListTasks,
    LogEntry,
    ReadLog,
    ReportOutcome,
    SubmitTask,
    Taken,
    TaskStatus,
)
from tca_bus._rights import Right
from tca_bus.tasktree import TOMBSTONE_SECONDS, KillRequested, Reported, Submitted, check_same

if TYPE_CHECKING:
    from tca_bus._central import Central

logger = logging.getLogger(__name__)

MOST_ENDED = 20
"""Ended top-level tasks that a listing shows."""


class Desk:
    """The handlers of central's own messages."""

    def __init__(self, central: Central) -> None:
        self._central = central
        self._clerk = Clerk(central)

    def serve(self, module: Module) -> None:
        """Register the handlers."""
        module.serve(SubmitTask, self.submit)
        module.serve(KillTask, self.kill)
        module.serve(FindTask, self.find)
        module.serve(ListTasks, self.tasks)
        module.serve(ReadLog, self.log)
        module.serve(ReportOutcome, self.report)

    async def submit(self, task: SubmitTask, context: Context) -> TaskStatus:
        """Make a node, or give the one that was made before."""
        await self._central.ready.wait()
        check_sender(task.id, task.sender, context.sender)
        self._clerk.check_submit(task)
        ended = None if task.is_new else await self._ended(task.id)
        if ended is not None:
            check_same(task, ended.name, ended.data)
            return ended
        if task.orders:
            orders = await without_past(self._central, task.orders, new=task.id)
            task = task.model_copy(update={"orders": tuple(orders)})
        await self._central.admit(task)
        # It may have come, and ended, while this one waited.
        if task.id not in self._central.recent:
            self._central.happen(Submitted(self._central.now(), task))
        return await self._known(task.id)

    async def kill(self, order: KillTask, context: Context) -> TaskStatus:
        """Kill a node; a kill that comes before its task is remembered for a while."""
        await self._central.ready.wait()
        self._central.tree.check_kill(order.id)
        ended = await self._ended(order.id)
        self._clerk.check(context.sender, Right.KILL, order.id, ended)
        if ended is not None:
            return ended
        reason = order.reason or f"killed by {context.sender}"
        kept = self._central.happen(
            KillRequested(self._central.now(), order.id, reason, order.only_below)
        )
        status = self._central.status(order.id)
        await kept
        if status is None:
            more = f" Should it come within {TOMBSTONE_SECONDS:g} s it is killed at once."
            raise unknown_task(self._central, order.id, more)
        return status

    async def find(self, question: FindTask, context: Context) -> TaskStatus:
        """The status of one task."""
        await self._central.ready.wait()
        status = await self._known(question.id)
        self._clerk.check_watch(context.sender, status)
        self._central.resources.note_await(question, context.sender)
        return status

    async def tasks(self, question: ListTasks, context: Context) -> list[TaskStatus]:
        """The nodes that are alive, or those at and below one; only what the asker may watch."""
        await self._central.ready.wait()
        if question.id is not None:
            found = await self._subtree(question.id)
        else:
            found = await self._forest(ended=question.ended)
        await self._central.committed()
        return self._clerk.watchable(context.sender, found)

    async def log(self, question: ReadLog, context: Context) -> list[LogEntry]:
        """Lines of the history: of one task, or of all."""
        await self._central.committed()
        if question.task is None:
            self._clerk.check_watch_all(context.sender)
        elif self._clerk.is_needed:
            self._clerk.check_watch(context.sender, await self._known(question.task))
        return await self._central.journal.read_log(question)

    async def report(self, report: ReportOutcome, context: Context) -> Taken:
        """Take the end of a handler; one that comes twice or too late changes nothing."""
        await self._central.ready.wait()
        self._check_reporter(report, context.sender)
        event = Reported(
            self._central.now(),
            report.id,
            report.attempt,
            report.outcome,
            report.result,
            report.failure,
            report.seen_failures,
            report.resolution,
        )
        await self._central.happen(event)
        return Taken(id=report.id, attempt=report.attempt)

    def _check_reporter(self, report: ReportOutcome, sender: str) -> None:
        """Let a module report only what it was given itself."""
        if not self._central.tree.is_current(report.id, report.attempt):
            return
        handler = self._central.tree.node(report.id).handler
        if handler != sender:
            why = f"module {handler!r} handles it, not {sender!r}"
            raise RefusedError(f"the outcome of task {report.id}", why)

    async def _ended(self, id: str) -> TaskStatus | None:
        """The last status of a task that is not in the tree any more, once it is kept."""
        if id in self._central.tree:
            return None
        status = await find_ended(self._central, id)
        if status is not None:
            await self._central.committed()
        return status

    async def _known(self, id: str) -> TaskStatus:
        """The status of a task, once it is in the journal: nothing else is told."""
        status = self._central.status(id) or await self._central.journal.find(id)
        if status is None:
            raise unknown_task(self._central, id)
        await self._central.committed()
        return status

    async def _forest(self, *, ended: bool) -> list[TaskStatus]:
        alive = self._central.tree.statuses()
        gone = await self._central.journal.last_ended(MOST_ENDED) if ended else []
        # One of those alive may have ended meanwhile.
        known = {status.id for status in gone}
        alive = [status for status in alive if status.id not in known]
        return [*gone, *alive, *(self._ended_below(alive) if ended else ())]

    def _ended_below(self, alive: list[TaskStatus]) -> list[TaskStatus]:
        """What ended lately below tasks that are alive; parents come before their children."""
        shown = {status.id for status in alive}
        found: list[TaskStatus] = []
        for status in reversed(self._central.recent.values()):
            if status.parent in shown and status.id not in shown:
                shown.add(status.id)
                found.append(status)
        return found

    async def _subtree(self, id: str) -> list[TaskStatus]:
        if id in self._central.tree:
            alive = self._central.tree.statuses(id)
            return [*alive, *self._ended_below(alive)]
        kept: dict[str, TaskStatus] = {}
        for status in await self._central.journal.ended_tree(id):
            if status.id == id or status.parent in kept:
                kept[status.id] = status
        if not kept:
            raise unknown_task(self._central, id)
        return list(kept.values())
