"""The handling side of tasks: central gives them, a handler runs, the outcome is reported."""

from __future__ import annotations

import asyncio
import logging
from dataclasses import dataclass, field
from typing import Any, Protocol

from tca_bus._clock import Clock
from tca_bus._context import Context
from tca_bus._core import Core
from tca_bus._envelope import begin_handling, handled
from tca_bus._errors import BusyError, RefusedError, TaskError, TaskFailedError, TcaError
from tca_bus._faults import failure_of
from tca_bus._handlers import Handler, Handlers
from tca_bus._messages import Message
from tca_bus._monitor_spec import MonitorSpec
from tca_bus._monitoring import Firing, MonitorRun
from tca_bus._outcomes import Outcomes, failed, killed
from tca_bus._protocol import CancelTask, HandleTask, Outcome, ReportOutcome, Taken
from tca_bus._task_context import ExceptionContext, MonitorContext, TaskContext
from tca_bus._task_reading import plain_result, read_task
from tca_bus._tasks import CENTRAL, TaskSender

logger = logging.getLogger(__name__)

SUPERSEDE_PATIENCE = 4.0
"""Wall seconds in which an older attempt ends; after that central has to ask again."""


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
    _outcomes: Outcomes = field(init=False)

    def __post_init__(self) -> None:
        self._outcomes = Outcomes(self.core, self.sender)

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
            message, handler = read_task(self.handlers, task)
            older = self._jobs.get(task.id)
            if older is None:
                self._start(task, message, handler)
            else:
                await self._supersede(older, task)
        return Taken(id=task.id, attempt=task.attempt)

    async def cancel(self, order: CancelTask, context: Context) -> Taken:
        """Cancel an attempt; one that is not known here is reported as killed."""
        _check_central(context, f"the end of task {order.id}")
        known = self._outcomes.known(order.id, order.attempt)
        job = self._jobs.get(order.id)
        if known is not None:
            self._outcomes.report(known)
        elif job is not None and job.task.attempt == order.attempt:
            self._stop(job)
        else:
            self._outcomes.conclude(killed(order.id, order.attempt))
        return Taken(id=order.id, attempt=order.attempt)

    def _is_known(self, task: HandleTask) -> bool:
        """Whether the attempt is under way, or done: then it is reported again."""
        outcome = self._outcomes.known(task.id, task.attempt)
        if outcome is not None:
            self._outcomes.report(outcome)
            return True
        job = self._jobs.get(task.id)
        return job is not None and job.task.attempt == task.attempt

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
        self._outcomes.conclude(outcome.model_copy(update={"seen_failures": seen}))

    def _clear(self, job: Job) -> None:
        job.over.set()
        if self._jobs.get(job.task.id) is job:
            del self._jobs[job.task.id]
        # A job that is cancelled before its first step never comes to its own report.
        if job.is_cancelled and not job.is_concluded:
            self._outcomes.conclude(killed(job.task.id, job.task.attempt))

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
        async with self.handlers.place(handler):
            value = await handler.call(message, context)
            if context.is_postponed:
                job.answer = asyncio.get_running_loop().create_future()
                value = await job.answer
        return plain_result(value, handler, job.task.message_revision)

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
            return killed(task.id, task.attempt)
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

    def _failed(self, task: HandleTask, error: Exception) -> ReportOutcome:
        if not isinstance(error, TaskError | TaskFailedError | TcaError):
            logger.error("handler of %s failed on task %s", task.name, task.id, exc_info=error)
        failure = failure_of(error, message=task.name, module=self.core.name, node=task.id)
        return failed(task, failure)


def _check_central(context: Context, what: str) -> None:
    """Let nobody but central give and stop tasks."""
    if context.sender != CENTRAL:
        raise RefusedError(what, f"it comes from {context.sender!r}; only {CENTRAL!r} may order it")
