"""The sending side of tasks: submitting them to central and following what becomes of them."""

from __future__ import annotations

import asyncio
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar
from weakref import WeakSet, WeakValueDictionary

from pydantic import TypeAdapter

from tca_bus._caller import Caller
from tca_bus._core import Core
from tca_bus._envelope import handled, sending_traceparent
from tca_bus._errors import (
    BusGoneError,
    BusyError,
    HandlerFailedError,
    NoHandlerError,
    PeerLostError,
    TaskFailedError,
    TcaError,
    TimedOutError,
)
from tca_bus._handle import TaskHandle
from tca_bus._messages import Query
from tca_bus._presence import PresenceChange
from tca_bus._protocol import FindTask, KillTask, SubmitTask, TaskStatus
from tca_bus._rights import Right
from tca_bus._topics import Arrival, Topics
from tca_bus._types import answer_adapter
from tca_bus._wire import build, decode_answer, encode_message

R = TypeVar("R")

CENTRAL = "central"

RETRY_DELAY = 0.1
"""Wall seconds before central is asked again after it could not be reached."""

TRY_TIMEOUT = 3.0
"""Wall seconds that one try to reach central may take."""

UNSEEN_GRACE = 3.0
"""Wall seconds to wait for a central that has never been seen."""

SIGHT_DELAY = 1.0
"""Wall seconds within which central sees a handler that the sender of a task sees."""

OUT_OF_REACH = (BusGoneError, BusyError, NoHandlerError, PeerLostError, TimedOutError)
"""What says that central is away or overrun, when it is not central's word on a task."""

STATUS_ENCODING = "application/json;tca.status@1"

_STATUS = TypeAdapter(TaskStatus)


@dataclass(eq=False)
class Early:
    """The newest state of a task that came before its acknowledgement."""

    id: str
    status: TaskStatus | None = None

    def take(self, status: TaskStatus) -> None:
        """Keep a state of the task, if it is newer than the one at hand."""
        if status.id == self.id and (not self.status or status.sequence > self.status.sequence):
            self.status = status


@dataclass
class TaskSender:
    """Submits tasks and keeps their handles informed."""

    core: Core
    caller: Caller
    topics: Topics
    _handles: WeakValueDictionary[str, WeakSet[TaskHandle[Any]]] = field(
        default_factory=WeakValueDictionary
    )
    _early: list[Early] = field(default_factory=list)
    _central_seen: bool = False
    holding: Callable[[], tuple[str, ...]] = tuple

    def begin(self) -> None:
        """Listen to the states of this module's tasks, and for central to come back."""
        key = self.core.keys.task(self.core.name, "*")
        self.topics.listen(key, decode_status, self._take)
        self.core.presence.listen(self._presence_changed)

    async def submit(
        self,
        task: SubmitTask,
        adapter: TypeAdapter[Any],
        *,
        timeout: float,
        on_failure: Callable[[str], None] | None = None,
    ) -> TaskHandle[Any]:
        """Send a task until central has acknowledged it.

        Raises:
            NoHandlerError: Nobody handles it, or there is no central.
            InvalidMessageError: The handler's module says that the data do not fit.
            RefusedError: This module may not send it, or central will not have it, e.g. another
                task has its id.
            TimedOutError: No acknowledgement within ``timeout``; it may have been made.
            BusGoneError: The router was away for the rest of that time.
        """
        right = Right.MONITOR if task.task_class == "monitor" else Right.SEND
        self.core.permissions.check_task(self.core.name, task.name, task.data, right=right)
        trace = sending_traceparent()
        if trace != task.traceparent:
            task = task.model_copy(update={"traceparent": trace})
        early = Early(task.id)
        self._early.append(early)
        try:
            status = await self._have_made(task, timeout)
        finally:
            self._early.remove(early)
        handle = TaskHandle[Any](status, self, adapter, on_failure)
        self._follow(handle)
        if early.status is not None:
            handle.update(early.status)
        return handle

    async def _have_made(self, task: SubmitTask, timeout: float) -> TaskStatus:
        """Send a task until central, which may see its handler last, has made the node."""
        begun = time.monotonic()
        while True:
            passed = time.monotonic() - begun
            try:
                return await self.ask_central(task, timeout=timeout - passed)
            except NoHandlerError as error:
                is_seen = self.core.presence.table.has_provider(task.name)
                is_late = passed + RETRY_DELAY > min(timeout, SIGHT_DELAY)
                if is_late or not is_seen or error.message != task.name:
                    raise
            await asyncio.sleep(RETRY_DELAY)

    def _follow(self, handle: TaskHandle[Any]) -> None:
        """Keep a handle informed for as long as somebody holds it, or another of its task."""
        kin = self._handles.get(handle.id)
        if kin is None:
            kin = self._handles[handle.id] = WeakSet()
        kin.add(handle)
        handle.kin = kin

    async def kill(
        self, task_id: str, *, reason: str, only_below: bool = False, timeout: float = 10.0
    ) -> TaskStatus:
        """Ask central to kill a task."""
        question = build(KillTask, id=task_id, reason=reason, only_below=only_below)
        return await self.ask_central(question, timeout=timeout)

    async def refresh(self, handle: TaskHandle[Any]) -> None:
        """Ask central for the state of a task; an unreachable central changes nothing.

        Raises:
            TaskFailedError: Central does not know the task: its journal is not the one of before.
        """
        try:
            status = await self._ask_once(self._question(handle.id), TRY_TIMEOUT)
        except OUT_OF_REACH:
            return
        except HandlerFailedError as error:
            raise TaskFailedError(handle.id, error.failure) from error
        handle.update(status)

    def _question(self, id: str) -> FindTask:
        """Asking says who waits: the task of the running handler, and what is held meanwhile."""
        inside = handled.get()
        return FindTask(id=id, awaited_by=inside.task if inside else None, holding=self.holding())

    async def ask_central(self, question: Query[R], *, timeout: float) -> R:
        """Ask central, again and again while it is out of reach, for at most ``timeout``."""
        deadline = time.monotonic() + timeout
        while True:
            left = deadline - time.monotonic()
            try:
                return await self._ask_once(question, min(max(left, 0.01), TRY_TIMEOUT))
            except OUT_OF_REACH as error:
                if not self._is_out_of_reach(question, error):
                    raise
                self._give_up_if_late(question, error, deadline, timeout)
                question = _again(question)
            await asyncio.sleep(RETRY_DELAY)

    async def _ask_once(self, question: Query[R], timeout: float) -> R:
        kind = type(question)
        payload = encode_message(question)
        answer = await self.caller.call(kind.wire_name, payload, to=CENTRAL, timeout=timeout)
        self._central_seen = True
        return decode_answer(answer, answer_adapter(kind), kind.wire_name, revision=kind.revision)  # type: ignore[no-any-return]

    def _is_out_of_reach(self, question: Query[Any], error: TcaError) -> bool:
        """Tell "no central" from central's own word that nobody handles the task."""
        if not isinstance(error, NoHandlerError):
            return True
        return error.message == f"{CENTRAL}:{type(question).wire_name}"

    def _give_up_if_late(
        self, question: Query[Any], error: TcaError, deadline: float, timeout: float
    ) -> None:
        if not self._central_seen and isinstance(error, NoHandlerError):
            deadline = min(deadline, deadline - timeout + UNSEEN_GRACE)
        if time.monotonic() + RETRY_DELAY < deadline:
            return
        if isinstance(error, TimedOutError | PeerLostError):
            what = f"central, asked for {type(question).wire_name!r}"
            raise TimedOutError(what, timeout) from error
        raise error

    def _take(self, arrival: Arrival[TaskStatus]) -> None:
        status = arrival.value
        for early in self._early:
            early.take(status)
        for handle in list(self._handles.get(status.id, ())):
            handle.update(status)

    def _presence_changed(self, change: PresenceChange) -> None:
        if change.module.name != CENTRAL or not change.appeared:
            return
        self._central_seen = True
        self.ask_again()

    def ask_again(self) -> None:
        """Have all who wait for a task ask central: states published meanwhile were lost."""
        for kin in list(self._handles.values()):
            for handle in list(kin):
                handle.ask_again()


def decode_status(payload: Any) -> tuple[TaskStatus]:
    """Validate a published task state."""
    return (decode_answer(payload, _STATUS, "tca.status"),)


def _again(question: Query[R]) -> Query[R]:
    """The question as it is sent again: central may have had it before."""
    is_new = getattr(question, "is_new", False)
    return question.model_copy(update={"is_new": False}) if is_new else question


def new_task_id(sender: str) -> str:
    """An id for a new task of a module."""
    return f"{sender}-{uuid.uuid4().hex[:20]}"
