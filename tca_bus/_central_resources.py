"""Resources at central: the ledger of holds on the bus, with its lines in the journal."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tca_bus._central_waits import TreeTasks
from tca_bus._context import Context
from tca_bus._errors import RefusedError, did_you_mean
from tca_bus._module import Module
from tca_bus._protocol import FindTask, Handling, TaskStatus
from tca_bus._resource_messages import (
    AcquireResources,
    CheckHolds,
    DeclareResource,
    HoldChanged,
    HoldKind,
    HoldState,
    HoldStatus,
    ListResources,
    ReleaseResources,
    ResourceStatus,
    UnlockResource,
)
from tca_bus._resource_report import Report
from tca_bus._rights import Right
from tca_bus.resources import HANDLERS, Changes, Ledger, Member
from tca_bus.tasktree import OWN, GateChanged, full_name

if TYPE_CHECKING:
    from tca_bus._central import Central

logger = logging.getLogger(__name__)

UNSEEN_GRACE = 3.0
"""Wall seconds in which a holder, or after a start any module, has to be seen on the bus."""

LOOK_PERIOD = 0.05
"""Wall seconds between two looks whether a module is known yet."""

MOST_RINGS = 1000
"""Rings that are remembered, so that each is logged once."""


@dataclass(slots=True)
class _Batch:
    changes: Changes
    done: asyncio.Future[None] = field(
        default_factory=lambda: asyncio.get_running_loop().create_future()
    )


class ResourceDesk:
    """Keeps the ledger: what changes is journaled, then told."""

    def __init__(self, central: Central) -> None:
        self._central = central
        self._tasks = TreeTasks(lambda: central.tree)
        self.ledger = Ledger(self._tasks)
        self._batches: list[_Batch] = []
        self._wake = asyncio.Event()
        self._rings: dict[str, None] = {}
        self._settled_at = 0.0

    def serve(self, module: Module) -> None:
        """Register the handlers of the messages about resources."""
        module.serve(AcquireResources, self.acquire)
        module.serve(ReleaseResources, self.release)
        module.serve(CheckHolds, self.check)
        module.serve(UnlockResource, self.unlock)
        module.serve(DeclareResource, self.declare)
        module.serve(ListResources, self.resources)

    async def begin(self) -> None:
        """Read the journal, once the task tree is there.

        Raises:
            JournalError: A line cannot be understood.
        """
        journal = self._central.journal
        self.ledger = Ledger(self._tasks, generation=journal.generation)
        self.ledger.replay(await journal.living_resource_events())
        self._settled_at = time.monotonic() + UNSEEN_GRACE
        self._central.module.start(self._write_batches(), name="central.resources")
        self._carry_out(self.ledger.settle(self._central.now()))
        tree = self._central.tree
        for task in {hold.request.task for hold in self.ledger.book.holds.values()} - {None}:
            if task is not None:
                self._task_is(task, tree.status(task) if task in tree else None)

    async def acquire(self, request: AcquireResources, context: Context) -> HoldStatus:
        """Hold resources, at once or as soon as it is this one's turn."""
        await self._central.ready.wait()
        if request.kind is HoldKind.LEASE:
            self._check_may_hold(context.sender, request.names)
        if self.ledger.status(request.id) is None:
            self._check_task(request, context.sender)
            self._look_for(request.incarnation)
        if request.kind is not HoldKind.LEASE:
            request = await self._named_in_full(request)
            self._check_may_hold(context.sender, request.names)
        await self._carry_out(self.ledger.ask(self._central.now(), context.sender, request))
        return self._status(request.id)

    async def release(self, request: ReleaseResources, context: Context) -> HoldStatus | None:
        """End a hold; one that comes after its release ends at once."""
        await self._central.ready.wait()
        hold = self.ledger.book.holds.get(request.id)
        if hold is None:
            self.ledger.forget(self._central.now(), request.id, context.sender)
        elif hold.module != context.sender:
            why = f"it is of {hold.module!r}; 'tca unlock' takes it away"
            raise RefusedError(f"the release of {request.id} by {context.sender!r}", why)
        await self._carry_out(self.ledger.finish(self._central.now(), request.id))
        return self.ledger.status(request.id)

    async def check(self, question: CheckHolds, _: Context) -> list[HoldStatus]:
        """What became of some holds."""
        await self._central.ready.wait()
        found = [self.ledger.status(id) for id in question.ids]
        await self._carry_out(Changes())
        return [status for status in found if status is not None]

    async def unlock(self, order: UnlockResource, context: Context) -> list[HoldStatus]:
        """Take a resource from whoever holds it."""
        await self._central.ready.wait()
        await self._until_known(order.name)
        name = self._resolve(order.name)
        self._check_may_hold(context.sender, [name])
        changes = self.ledger.unlock(self._central.now(), name, context.sender)
        await self._carry_out(changes)
        return [status for status in changes.statuses if status.state is HoldState.ENDED]

    async def declare(self, facts: DeclareResource, context: Context) -> None:
        """Note how many places a thing has."""
        await self._central.ready.wait()
        self._check_may_hold(context.sender, [facts.name])
        known = self.ledger.book.things.get(facts.name)
        if known is not None and known.capacity != facts.capacity:
            text = "module %s changes the capacity of %s from %d to %d"
            logger.warning(text, context.sender, facts.name, known.capacity, facts.capacity)
        changes = self.ledger.declare(
            self._central.now(), facts.name, facts.capacity, facts.pending
        )
        await self._carry_out(changes)

    async def resources(self, _question: ListResources, _: Context) -> list[ResourceStatus]:
        """All resources, who holds them and who waits."""
        await self._central.ready.wait()
        tasks = self._tasks.waiting_tasks()
        listed = Report(self.ledger, self._central.tree, tasks).resources()
        await self._carry_out(Changes())
        return listed

    def note_await(self, question: FindTask, sender: str) -> None:
        """Somebody awaits a task, in a handler or with holds: see whether that closes a ring."""
        own = [id for id in question.holding if self._is_of(id, sender)]
        task = question.awaited_by
        if task is not None and self._handler(task) != sender:
            task = None
        if task is None and not own:
            return
        self._tasks.note(question.id, task=task, holding=own)
        waits: list[Member] = [("hold", id) for id in own]
        for start in waits if task is None else [*waits, ("task", task)]:
            ring = self.ledger.ring_behind(start)
            if ring is not None:
                self._log_once(self.ledger.words(ring))

    def module_gone(self, incarnation: str) -> None:
        """A module is gone for good."""
        self._carry_out(self.ledger.holder_gone(self._central.now(), incarnation))

    def keep_only(self, present: set[str]) -> None:
        """These modules are there; holders that are not have died while central was away."""
        holders = {hold.request.incarnation for hold in self.ledger.book.holds.values()}
        for incarnation in holders - present - {None}:
            self.module_gone(incarnation or "")

    def task_changed(self, status: TaskStatus) -> None:
        """A task has another state: holds of tries that are over end."""
        if self.ledger.book.of_task(status.id):
            self._task_is(status.id, status)

    def tree_changed(self) -> None:
        """Handlers may have ended for which a lock or reservation waits."""
        if self.ledger.book.shutting():
            self._carry_out(self.ledger.settle(self._central.now()))

    def _task_is(self, task: str, status: TaskStatus | None) -> None:
        attempt = None
        if status is not None and not status.is_ended:
            attempt = 0 if status.handling is Handling.UNHANDLED else status.attempt
        self._carry_out(self.ledger.task_moved(self._central.now(), task, attempt))

    def _carry_out(self, changes: Changes) -> asyncio.Future[None]:
        """Shut and open gates, then have the records written; done when that is."""
        batch = _Batch(changes)
        self._batches.append(batch)
        self._wake.set()
        for name, gate in changes.gates.items():
            self._central.happen(GateChanged(self._central.now(), name, gate))
        return batch.done

    async def _write_batches(self) -> None:
        """Write all that came since the last commit in one transaction, then tell of it."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            batches, self._batches = self._batches, []
            changes = [batch.changes for batch in batches]
            if any(change.records for change in changes):
                await self._central.journal.write_resources(changes)
            for status in (status for each in changes for status in each.statuses):
                await self._central.module.broadcast(HoldChanged(status=status))
            for batch in batches:
                if not batch.done.done():
                    batch.done.set_result(None)

    def _check_may_hold(self, sender: str, names: Iterable[str]) -> None:
        """Let a module hold what the policy lets it, and the resources of its own handlers."""
        for full in names:
            module, mark, name = full.partition(HANDLERS)
            owner, name = (module, name or module) if mark else (None, full)
            self._central.permissions.check(sender, Right.LOCK, name, owner=owner)

    def _check_task(self, request: AcquireResources, sender: str) -> None:
        """Let a module hold something only for a task that it is handling."""
        task = request.task
        if task is None:
            return
        is_current = self._central.tree.is_current(task, request.attempt)
        if not is_current or self._handler(task) != sender:
            what = f"holding {', '.join(request.names)} for task {task}"
            raise RefusedError(what, f"{sender!r} is not handling try {request.attempt} of it")

    def _handler(self, task: str) -> str | None:
        tree = self._central.tree
        return tree.status(task).handler if task in tree else None

    def _is_of(self, id: str, module: str) -> bool:
        hold = self.ledger.book.holds.get(id)
        return hold is not None and hold.module == module and hold.granted is not None

    def _look_for(self, incarnation: str | None) -> None:
        """A holder that is not seen has died already, or is about to be seen."""
        if incarnation is not None and not self._is_present(incarnation):
            looking = self._part_with_unseen(incarnation)
            self._central.module.start(looking, name=f"central.look_for.{incarnation}")

    async def _part_with_unseen(self, incarnation: str) -> None:
        await asyncio.sleep(UNSEEN_GRACE)
        if not self._is_present(incarnation):
            self.module_gone(incarnation)

    def _is_present(self, incarnation: str) -> bool:
        return any(m.incarnation == incarnation for m in self._central.module.modules())

    async def _named_in_full(self, request: AcquireResources) -> AcquireResources:
        """The request for a lock or reservation, with the full name of what is meant."""
        known = self.ledger.book.holds.get(request.id)
        if known is not None:
            return request.model_copy(update={"names": known.names})
        for name in request.names:
            await self._until_known(name)
        names = tuple(self._resolve(name) for name in request.names)
        return request.model_copy(update={"names": names})

    async def _until_known(self, name: str) -> None:
        """Shortly after a start the module whose resource it is may not be known yet."""
        while time.monotonic() < self._settled_at and not self._is_known(name):  # noqa: ASYNC110
            await asyncio.sleep(LOOK_PERIOD)

    def _is_known(self, name: str) -> bool:
        known = (*self._handlers_resources(), *self.ledger.book.names())
        return any(name in {full, full.partition(HANDLERS)[2]} for full in known)

    def _resolve(self, name: str) -> str:
        """The full name of what is meant: a thing, or the one handlers' resource of the name.

        Raises:
            RefusedError: There is no such handlers' resource, or there are several.
        """
        handlers = self._handlers_resources()
        known = {*handlers, *self.ledger.book.names()}
        if name in known:
            return name
        if HANDLERS in name:
            near = did_you_mean(name, known)
            raise RefusedError(f"holding {name!r}", f"no module has that resource.{near}")
        own = full_name(name, OWN)
        found = [full for full in handlers if full.split(HANDLERS)[1] == name]
        if not found and own in handlers:
            return own
        if len(found) > 1:
            raise RefusedError(f"holding {name!r}", f"there are several: {', '.join(found)}")
        return found[0] if found else name

    def _handlers_resources(self) -> list[str]:
        providers = self._central.tree.pools.providers()
        return sorted({full_name(p.module, r) for p in providers if p.present for r in p.resources})

    def _status(self, id: str) -> HoldStatus:
        status = self.ledger.status(id)
        assert status is not None
        return status

    def _log_once(self, ring: str) -> None:
        if ring not in self._rings:
            logger.warning("these wait for each other for ever: %s", ring)
            self._rings[ring] = None
        while len(self._rings) > MOST_RINGS:
            del self._rings[next(iter(self._rings))]
