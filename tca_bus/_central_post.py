"""What central sends to modules: tasks to handle and to stop, again until they are taken."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Coroutine
from typing import TYPE_CHECKING, Any

from tca_bus._envelope import Envelope, handled
from tca_bus._errors import (
    BusGoneError,
    BusyError,
    HandlerFailedError,
    InvalidMessageError,
    NoHandlerError,
    PeerLostError,
    RefusedError,
    TcaError,
    TimedOutError,
)
from tca_bus._failure import Failure
from tca_bus._presence import PresentModule
from tca_bus._protocol import CancelTask, HandleTask, Outcome
from tca_bus._trace_context import node_context
from tca_bus.tasktree import Abandoned, Cancel, Dispatch, Reported, Taken, Tell

if TYPE_CHECKING:
    from tca_bus._central import Central

logger = logging.getLogger(__name__)

PATIENCE = 5.0
"""Wall seconds that a module may take to say that it has a task."""

RETRY_DELAY = 0.1
"""Wall seconds before a module is asked again."""

UNREACHED = (BusGoneError, BusyError, PeerLostError, TimedOutError)
"""The module did not take it, or may not have got it; whether it is gone, presence will tell."""

HANDED_ON = (
    "id",
    "name",
    "task_class",
    "message_revision",
    "data",
    "sender",
    "parent",
    "grace",
    "monitor",
)
"""The facts of a submission that its handler is given."""

REFUSALS = {
    HandlerFailedError: "handler_error",
    InvalidMessageError: "invalid_message",
    NoHandlerError: "no_handler",
    RefusedError: "refused",
}


class Post:
    """One sending at a time for each node; the order to stop it replaces the order to begin."""

    def __init__(self, central: Central) -> None:
        self._central = central
        self._under_way: dict[str, asyncio.Task[None]] = {}

    def dispatch(self, order: Dispatch) -> None:
        """Have a module handle a try of a node."""
        self._begin(order.id, self._dispatch(order), f"central.dispatch.{order.id}")

    def cancel(self, order: Cancel) -> None:
        """Have a module stop a try of a node; after its grace it is waited for no longer."""
        self._begin(order.id, self._cancel(order), f"central.cancel.{order.id}")
        asyncio.get_running_loop().call_later(order.grace, self._abandon, order)

    def tell(self, effect: Tell) -> None:
        """Send an inform or broadcast of a tap."""
        name = effect.sending.name
        self._central.module.start(self._tell(effect), name=f"central.tell.{name}")

    def recall(self, id: str, attempt: int, incarnation: str) -> None:
        """Have a module stop a try that went on after the module was taken for lost."""
        reason = "its module was taken for lost meanwhile"
        recalling = self._recall(CancelTask(id=id, attempt=attempt, reason=reason), incarnation)
        self._central.module.start(recalling, name=f"central.recall.{id}")

    def _begin(self, id: str, sending: Coroutine[Any, Any, None], name: str) -> None:
        before = self._under_way.pop(id, None)
        if before is not None:
            before.cancel()
        task = self._central.module.start(sending, name=name)
        self._under_way[id] = task
        task.add_done_callback(lambda done: self._finished(id, done))

    def _finished(self, id: str, task: asyncio.Task[None]) -> None:
        if self._under_way.get(id) is task:
            del self._under_way[id]

    def _abandon(self, order: Cancel) -> None:
        central = self._central
        if not central.tree.is_current(order.id, order.attempt) or central.module.is_closed:
            return
        logger.warning(
            "handler of task %s in %s did not stop within %g s and is abandoned",
            order.id,
            order.module,
            order.grace,
        )
        central.happen(Abandoned(central.now(), order.id, order.attempt))

    async def _tell(self, effect: Tell) -> None:
        sending, module = effect.sending, self._central.module
        try:
            if sending.task_class == "inform":
                await module.inform_json(sending.name, sending.data)
            else:
                await module.broadcast_json(sending.name, sending.data)
        except TcaError as error:
            logger.warning("the listener %s of a tap was not told: %s", sending.name, error)

    async def _dispatch(self, order: Dispatch) -> None:
        while self._central.tree.is_current(order.id, order.attempt):
            target = self._find(order.incarnation)
            if target is not None and await self._give(order, target):
                return
            await asyncio.sleep(RETRY_DELAY)

    async def _give(self, order: Dispatch, target: PresentModule) -> bool:
        node = self._central.tree.node(order.id)
        span = node_context(order.id, node.task.traceparent)
        handled.set(Envelope(id=order.id, traceparent=str(span)))
        facts = {name: getattr(node.task, name) for name in HANDED_ON}
        try:
            task = HandleTask(attempt=order.attempt, retries=node.retries, **facts)
            await self._central.module.query(task, to=target, timeout=PATIENCE)
        except UNREACHED as error:
            logger.info("task %s is not taken yet by %s: %s", order.id, target.name, error)
            return False
        except TcaError as error:
            self._refused(order, error)
            return True
        self._central.happen(Taken(self._central.now(), order.id, order.attempt))
        return True

    def _refused(self, order: Dispatch, error: TcaError) -> None:
        name = REFUSALS.get(type(error), "handler_error")
        failure = Failure(name=name, text=str(error), node=order.id, module=order.module)
        report = Reported(
            self._central.now(), order.id, order.attempt, Outcome.FAILURE, failure=failure
        )
        self._central.happen(report)

    async def _cancel(self, order: Cancel) -> None:
        stop = CancelTask(id=order.id, attempt=order.attempt, reason=order.reason)
        while self._central.tree.is_current(order.id, order.attempt):
            target = self._find(order.incarnation)
            if target is not None and await self._stop(stop, target):
                return
            await asyncio.sleep(RETRY_DELAY)

    async def _recall(self, stop: CancelTask, incarnation: str) -> None:
        while (target := self._find(incarnation)) is not None:
            if await self._stop(stop, target):
                return
            await asyncio.sleep(RETRY_DELAY)

    async def _stop(self, stop: CancelTask, target: PresentModule) -> bool:
        try:
            await self._central.module.query(stop, to=target, timeout=PATIENCE)
        except UNREACHED as error:
            logger.info("task %s is not stopped yet by %s: %s", stop.id, target.name, error)
            return False
        except TcaError as error:
            logger.warning("module %s does not stop task %s: %s", target.name, stop.id, error)
            return False
        return True

    def _find(self, incarnation: str) -> PresentModule | None:
        modules = self._central.module.modules()
        return next((m for m in modules if m.incarnation == incarnation), None)
