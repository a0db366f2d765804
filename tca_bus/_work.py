"""The handling side of tasks: central gives them, a handler runs, the outcome is reported."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import OrderedDict
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any, Protocol

from pydantic import ValidationError

from tca_bus._attachments import Caught
from tca_bus._clock import Clock
from tca_bus._context import Context
from tca_bus._core import Core
from tca_bus._envelope import begin_handling, handled
from tca_bus._errors import (
    BusyError,
    ClosedError,
    InvalidMessageError,
    NoHandlerError,
    RefusedError,
    TaskError,
    TaskFailedError,
    TcaError,
)
from tca_bus._failure import Failure
from tca_bus._faults import failure_of
from tca_bus._handlers import TASKS, Handler, Handlers
from tca_bus._messages import Message, MessageClass
from tca_bus._monitor_spec import MonitorSpec
from tca_bus._monitoring import Firing, MonitorRun
from tca_bus._problems import problems_of
from tca_bus._protocol import CancelTask, HandleTask, Outcome, ReportOutcome, Taken
from tca_bus._revisions import answer_for, understand
from tca_bus._task_context import ExceptionContext, MonitorContext, TaskContext
from tca_bus._tasks import CENTRAL, OUT_OF_REACH, TaskSender
from tca_bus._types import answer_adapter

logger = logging.getLogger(__name__)

MOST_REPORTED = 1024
"""Acknowledged outcomes that are kept, to report again should central ask again."""

REPORT_PATIENCE = 60.0
"""Wall seconds of one attempt to report; a report is repeated for as long as the module lives."""

SUPERSEDE_PATIENCE = 4.0
"""Wall seconds in which an older attempt ends; after that central has to ask again."""

Try = tuple[str, int]
"""A task id and the attempt number."""


class Contexts(Protocol):
    """Makes what handlers are given beside their messages."""

    def plain(self, *, sender: str, id: str) -> Context:
        """For a condition that is tested."""
        ...

    def task(self, task: HandleTask) -> TaskContext:
        """For a goal, a command or an exception."""
        ...

    def monitor(self, task: HandleTask, firing: Firing) -> MonitorContext:
        """For a demon."""
        ...

    def clock(self) -> Clock:
        """The clock of the module."""
        ...


@dataclass(eq=False)
class Job:
    """One attempt at a task in this module."""

    task: HandleTask
    running: asyncio.Task[None] | None = None
    is_cancelled: bool = False
    is_concluded: bool = False
    answer: asyncio.Future[Any] | None = None
    over: asyncio.Event = field(default_factory=asyncio.Event)


@dataclass
class TaskWorker:
    """Runs the handlers of goals and commands, each attempt once."""

    core: Core
    handlers: Handlers
    sender: TaskSender
    contexts: Contexts
    _jobs: dict[str, Job] = field(default_factory=dict)
    _outcomes: OrderedDict[Try, ReportOutcome] = field(default_factory=OrderedDict)
    _reporting: set[Try] = field(default_factory=set)
    _slots: dict[str, asyncio.Semaphore] = field(default_factory=dict)

    def begin(self) -> None:
        """Register the handlers by which central gives and cancels tasks."""
        self.handlers.add(HandleTask, self.take, built_in=True)
        self.handlers.add(CancelTask, self.cancel, built_in=True)

    def handling(self) -> list[Taken]:
        """The attempts whose handlers run or wait for a free slot."""
        return [Taken(id=id, attempt=job.task.attempt) for id, job in self._jobs.items()]

    async def take(self, task: HandleTask, context: Context) -> Taken:
        """Begin an attempt, or say again that it is under way or done."""
        _check_central(context, f"task {task.id}")
        while not self._is_known(task):
            message, handler = self._read(task)
            older = self._jobs.get(task.id)
            if older is None:
                self._start(task, message, handler)
            else:
                await self._supersede(older, task)
        return Taken(id=task.id, attempt=task.attempt)

    async def cancel(self, order: CancelTask, context: Context) -> Taken:
        """Cancel an attempt; one that is not known here is reported as killed."""
        _check_central(context, f"the end of task {order.id}")
        known = self._outcomes.get((order.id, order.attempt))
        job = self._jobs.get(order.id)
        if known is not None:
            self._report(known)
        elif job is not None and job.task.attempt == order.attempt:
            self._stop(job)
        else:
            self._conclude(_killed(order.id, order.attempt))
        return Taken(id=order.id, attempt=order.attempt)

    def _is_known(self, task: HandleTask) -> bool:
        """Whether the attempt is under way, or done: then it is reported again."""
        outcome = self._outcomes.get((task.id, task.attempt))
        if outcome is not None:
            self._report(outcome)
            return True
        job = self._jobs.get(task.id)
        return job is not None and job.task.attempt == task.attempt

    def _read(self, task: HandleTask) -> tuple[Message, Handler]:
        handler = self.handlers.get(task.name)
        if handler is None or not _fits(handler, task):
            raise NoHandlerError(task.name, self.handlers.provided())
        kind = handler.message_type
        if task.task_class == "exception":
            return _exception(kind, task), handler
        if kind.message_class in TASKS and kind.message_class.value != task.task_class:
            problem = f"class: expected {kind.message_class.value}, got {task.task_class}"
            raise InvalidMessageError(task.name, [problem])
        try:
            message = understand(
                kind,
                task.message_revision,
                validate=lambda: kind.model_validate(task.data),
                plain=lambda: deepcopy(task.data),
            )
        except ValidationError as error:
            raise InvalidMessageError(task.name, problems_of(error)) from error
        return message, handler

    async def _supersede(self, job: Job, task: HandleTask) -> None:
        """Stop an older attempt; the newer one begins when its handler has ended."""
        if job.task.attempt > task.attempt:
            what = f"attempt {task.attempt} of {task.id}"
            raise RefusedError(what, f"attempt {job.task.attempt} is under way")
        self._stop(job)
        try:
            async with asyncio.timeout(SUPERSEDE_PATIENCE):
                await job.over.wait()
        except TimeoutError as error:
            why = f"attempt {job.task.attempt} has not stopped yet"
            raise BusyError(f"attempt {task.attempt} of {task.id}", why) from error

    def _start(self, task: HandleTask, message: Message, handler: Handler) -> None:
        job = self._jobs[task.id] = Job(task)
        name = f"{self.core.name}.task.{task.name}"
        job.running = self.core.spawn(self._run(job, message, handler), name=name)
        job.running.add_done_callback(lambda _: self._clear(job))

    def _stop(self, job: Job) -> None:
        if job.running is not None and not job.is_cancelled:
            job.is_cancelled = True
            job.running.cancel()

    async def _run(self, job: Job, message: Message, handler: Handler) -> None:
        context = self.contexts.task(job.task)
        envelope = handled.get()
        if envelope is not None:
            begin_handling(envelope.model_copy(update={"task": job.task.id}))
        outcome = await self._outcome_of(job, message, handler, context)
        seen = tuple(context.seen_failures)
        job.is_concluded = True
        self._conclude(outcome.model_copy(update={"seen_failures": seen}))

    def _clear(self, job: Job) -> None:
        job.over.set()
        if self._jobs.get(job.task.id) is job:
            del self._jobs[job.task.id]
        # A job that is cancelled before its first step never comes to its own report.
        if job.is_cancelled and not job.is_concluded:
            self._conclude(_killed(job.task.id, job.task.attempt))

    def answer(self, id: str, result: Any) -> None:
        """End a postponed task; with an exception it fails.

        Raises:
            TaskError: There is no such task here, or its handler did not postpone it.
        """
        job = self._jobs.get(id)
        if job is None or job.answer is None or job.answer.done():
            raise TaskError("not_postponed", f"task {id} waits for no answer in this module")
        if isinstance(result, Exception):
            job.answer.set_exception(result)
        else:
            job.answer.set_result(result)

    async def _value_of(
        self, job: Job, message: Message, handler: Handler, context: TaskContext
    ) -> Any:
        """Run the handler, and wait for its answer if that is postponed."""
        if job.task.monitor is not None:
            return await self._monitor(job.task, job.task.monitor, message, handler).run()
        async with self._slot(handler):
            value = await handler.call(message, context)
            if context.is_postponed:
                job.answer = asyncio.get_running_loop().create_future()
                value = await job.answer
        return _plain_result(value, handler, job.task.message_revision)

    def _monitor(
        self, task: HandleTask, spec: MonitorSpec, message: Message, handler: Handler
    ) -> MonitorRun:
        return MonitorRun(
            task=task,
            spec=spec,
            message=message,
            handler=handler,
            firing=Firing(self.sender, task),
            context=self.contexts.plain,
            demon=lambda firing: self.contexts.monitor(task, firing),
            clock=self.contexts.clock,
        )

    async def _outcome_of(
        self, job: Job, message: Message, handler: Handler, context: TaskContext
    ) -> ReportOutcome:
        task = job.task
        try:
            result = await self._value_of(job, message, handler, context)
        except asyncio.CancelledError:
            if not job.is_cancelled:
                raise
            return _killed(task.id, task.attempt)
        except Exception as error:
            return self._failed(task, error)
        resolution = context.resolution if isinstance(context, ExceptionContext) else None
        return ReportOutcome(
            id=task.id,
            attempt=task.attempt,
            outcome=Outcome.SUCCESS,
            result=result,
            resolution=resolution,
        )

    def _slot(self, handler: Handler) -> asyncio.Semaphore:
        return self._slots.setdefault(handler.name, asyncio.Semaphore(handler.capacity or 1))

    def _failed(self, task: HandleTask, error: Exception) -> ReportOutcome:
        if not isinstance(error, TaskError | TaskFailedError | TcaError):
            logger.error("handler of %s failed on task %s", task.name, task.id, exc_info=error)
        failure = failure_of(error, message=task.name, module=self.core.name, node=task.id)
        return _failure_report(task, failure)

    def _conclude(self, report: ReportOutcome) -> None:
        self._outcomes[report.id, report.attempt] = report
        self._report(report)
        if len(self._outcomes) > MOST_REPORTED:
            self._forget_oldest()

    def _forget_oldest(self) -> None:
        """Forget the oldest outcome that central has; the others are as many as it gave tasks."""
        oldest = next((key for key in self._outcomes if key not in self._reporting), None)
        if oldest is not None:
            del self._outcomes[oldest]

    def _report(self, report: ReportOutcome) -> None:
        key = (report.id, report.attempt)
        if key in self._reporting:
            return
        name = f"{self.core.name}.report.{report.id}"
        # A module that is closing reports no more; central sees it leave.
        with contextlib.suppress(ClosedError):
            self.core.spawn(self._report_until_taken(report), name=name)
            self._reporting.add(key)

    async def _report_until_taken(self, report: ReportOutcome) -> None:
        key = (report.id, report.attempt)
        try:
            while True:
                try:
                    await self.sender.ask_central(report, timeout=REPORT_PATIENCE)
                except OUT_OF_REACH as error:
                    logger.warning("outcome of task %s is not reported yet: %s", report.id, error)
                else:
                    return
        except TcaError:
            logger.exception("central does not take the outcome of task %s", report.id)
        finally:
            self._reporting.discard(key)


def _check_central(context: Context, what: str) -> None:
    """Let nobody but central give and stop tasks."""
    if context.sender != CENTRAL:
        raise RefusedError(what, f"it comes from {context.sender!r}; only {CENTRAL!r} may order it")


def _fits(handler: Handler, task: HandleTask) -> bool:
    """Whether the handler of that name can be meant."""
    kind = handler.message_type.message_class
    if task.task_class == "exception":
        return kind == MessageClass.EXCEPTION
    if task.monitor is not None:
        return kind == (MessageClass.DEMON if task.monitor.kind == "demon" else MessageClass.QUERY)
    return kind in TASKS


def _exception(kind: type[Message], task: HandleTask) -> Message:
    """The exception that a handler of it is given; one of any kind is given without data."""
    failure = Failure.model_validate(Caught.model_validate(task.data).failure)
    try:
        if kind.wire_name in {failure.name, *failure.kinds}:
            known = failure.data or {}
            fields = {name: known[name] for name in kind.model_fields if name in known}
            return kind.model_validate(fields)
        return kind()
    except ValidationError as error:
        raise InvalidMessageError(task.name, problems_of(error)) from error


def _plain_result(value: Any, handler: Handler, told: int | None) -> Any:
    """The result as JSON values, in the sender's form; one of another type is a failure."""
    adapter = answer_adapter(handler.message_type)
    try:
        result = adapter.dump_python(adapter.validate_python(value), mode="json")
    except ValidationError as error:
        raise TaskError("invalid_result", f"result: {'; '.join(problems_of(error))}") from error
    return answer_for(handler.message_type, told, result)[0]


def _killed(id: str, attempt: int) -> ReportOutcome:
    return ReportOutcome(id=id, attempt=attempt, outcome=Outcome.KILLED)


def _failure_report(task: HandleTask, failure: Failure) -> ReportOutcome:
    return ReportOutcome(id=task.id, attempt=task.attempt, outcome=Outcome.FAILURE, failure=failure)
