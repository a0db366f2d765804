"""The handling side of tasks, with a central whose every move the test makes."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest

from tca_bus import (
    BusyError,
    Command,
    Goal,
    InvalidMessageError,
    Module,
    NoHandlerError,
    Query,
    RefusedError,
    TaskError,
    TaskFailedError,
)
from tca_bus._failure import Failure
from tca_bus._protocol import CancelTask, Describe, HandleTask, Outcome, ReportOutcome, Taken
from tca_bus.testing import bus, eventually

pytestmark = pytest.mark.bus


class Toil(Command[int]):
    number: int


class Plan(Goal[None]):
    pass


class Ask(Query[int]):
    pass


class Desk:
    """A module named central that only takes reports; while shut it refuses to answer."""

    def __init__(self, options):
        self.module = Module("central", options=options)
        self.tries = 0
        self.reports: list[ReportOutcome] = []
        self.is_open = asyncio.Event()
        self.is_open.set()
        self.module.serve(ReportOutcome, self.report)

    async def report(self, report, context):
        self.tries += 1
        await self.is_open.wait()
        self.reports.append(report)
        return Taken(id=report.id, attempt=report.attempt)

    async def hand(self, number, *, id="t-1", attempt=1, **changes):
        fields = {"name": "toil", "task_class": "command", "data": {"number": number}}
        task = HandleTask(id=id, attempt=attempt, sender="x", **(fields | changes))
        return await self.module.query(task, to="worker")

    async def cancel(self, *, id="t-1", attempt=1):
        order = CancelTask(id=id, attempt=attempt, reason="enough")
        return await self.module.query(order, to="worker")


class Worker:
    """A module that toils: negative numbers fail, zero waits to be told."""

    def __init__(self, options, capacity=1):
        self.module = Module("worker", options=options)
        self.go = asyncio.Event()
        self.begun: list[tuple[str, int]] = []
        self.most = 0
        self.running = 0
        self.module.serve(Toil, self.toil, capacity=capacity)

    async def toil(self, message, context):
        self.begun.append((context.id, context.attempt))
        self.running += 1
        self.most = max(self.most, self.running)
        try:
            if message.number == 0:
                await self.go.wait()
            if message.number < 0:
                raise TaskError("negative", "below zero", data={"number": message.number})
            return message.number * 2
        finally:
            self.running -= 1


@asynccontextmanager
async def shop(capacity=1):
    async with bus() as options:
        desk, worker = Desk(options), Worker(options, capacity)
        async with desk.module, worker.module:
            await desk.module.wait_for(Toil, timeout=10.0)
            yield desk, worker


async def test_a_handler_that_returns_has_succeeded():
    async with shop() as (desk, _):
        assert await desk.hand(21) == Taken(id="t-1", attempt=1)
        await eventually(lambda: desk.reports)
        report = desk.reports[0]
        assert (report.outcome, report.result, report.failure) == (Outcome.SUCCESS, 42, None)


async def test_a_handler_that_raises_has_failed_and_says_how():
    async with shop() as (desk, _):
        await desk.hand(-3)
        await eventually(lambda: desk.reports)
        failure = desk.reports[0].failure
        assert failure is not None
        assert (failure.name, failure.text, failure.data) == (
            "negative",
            "below zero",
            {"number": -3},
        )
        assert (failure.message, failure.module, failure.node) == ("toil", "worker", "t-1")


async def test_an_attempt_that_is_given_twice_runs_once():
    async with shop() as (desk, worker):
        await desk.hand(0)
        await desk.hand(0)
        await eventually(lambda: worker.begun)
        card = await desk.module.query(Describe(), to="worker")
        assert card.handling == [Taken(id="t-1", attempt=1)]
        worker.go.set()
        await eventually(lambda: desk.reports)
        assert worker.begun == [("t-1", 1)]


async def test_an_outcome_that_central_asks_for_again_is_reported_again():
    async with shop() as (desk, worker):
        await desk.hand(4)
        await eventually(lambda: len(desk.reports) == 1)
        await desk.hand(4)
        await eventually(lambda: len(desk.reports) == 2)
        await desk.cancel()
        await eventually(lambda: len(desk.reports) == 3)
        assert {report.result for report in desk.reports} == {8}
        assert worker.begun == [("t-1", 1)]


async def test_a_cancelled_handler_is_reported_as_killed():
    async with shop() as (desk, worker):
        await desk.hand(0)
        await eventually(lambda: worker.begun)
        await desk.cancel()
        await eventually(lambda: desk.reports)
        assert desk.reports[0].outcome == Outcome.KILLED
        assert worker.running == 0


async def test_what_is_cancelled_before_it_began_is_killed_too():
    async with shop() as (desk, worker):
        await desk.hand(0, id="first")
        await eventually(lambda: worker.begun)
        await desk.hand(0, id="second")
        await desk.cancel(id="second")
        await eventually(lambda: desk.reports)
        assert [(report.id, report.outcome) for report in desk.reports] == [
            ("second", Outcome.KILLED)
        ]
        assert worker.begun == [("first", 1)]


async def test_cancelling_what_never_came_keeps_it_from_starting():
    async with shop() as (desk, worker):
        await desk.cancel()
        await eventually(lambda: len(desk.reports) == 1)

        async def is_reported_again():
            # While the first report is not acknowledged yet, no second one is begun.
            await desk.hand(5)
            return len(desk.reports) > 1

        await eventually(is_reported_again)
        assert {report.outcome for report in desk.reports} == {Outcome.KILLED}
        assert worker.begun == []


@pytest.mark.parametrize("capacity", [1, 3])
async def test_no_more_run_at_once_than_the_capacity(capacity):
    async with shop(capacity) as (desk, worker):
        for number in range(6):
            await desk.hand(0, id=f"t-{number}")
        await eventually(lambda: worker.running == capacity)
        worker.go.set()
        await eventually(lambda: len(desk.reports) == 6)
        assert worker.most == capacity
        assert [id for id, _ in worker.begun] == [f"t-{number}" for number in range(6)]


async def test_a_newer_attempt_takes_the_place_of_the_older_one():
    async with shop() as (desk, worker):
        await desk.hand(0, attempt=1)
        await eventually(lambda: worker.begun == [("t-1", 1)])
        await desk.hand(7, attempt=2)
        await eventually(lambda: len(desk.reports) == 2)
        assert {(r.attempt, r.outcome) for r in desk.reports} == {
            (1, Outcome.KILLED),
            (2, Outcome.SUCCESS),
        }


class Stubborn(Worker):
    """Takes its time to end when it is cancelled."""

    async def toil(self, message, context):
        self.begun.append((context.id, context.attempt))
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            await self.go.wait()
            raise


@asynccontextmanager
async def stubborn_shop():
    """A shop in which attempt 1 of ``t-1`` runs."""
    async with bus() as options:
        desk, worker = Desk(options), Stubborn(options, capacity=2)
        async with desk.module, worker.module:
            await desk.module.wait_for(Toil, timeout=10.0)
            await desk.hand(0)
            await eventually(lambda: worker.begun)
            yield desk, worker


async def test_a_newer_attempt_that_is_given_twice_runs_once():
    async with stubborn_shop() as (desk, worker), asyncio.TaskGroup() as group:
        given = [group.create_task(desk.hand(0, attempt=2)) for _ in range(2)]
        await eventually(lambda: worker.module._parts.worker._jobs["t-1"].is_cancelled)
        worker.go.set()
        await asyncio.wait(given)
        await eventually(lambda: len(worker.begun) > 1)
        assert worker.begun == [("t-1", 1), ("t-1", 2)]


async def test_a_newer_attempt_that_is_cancelled_while_it_waits_does_not_begin():
    async with stubborn_shop() as (desk, worker), asyncio.TaskGroup() as group:
        given = group.create_task(desk.hand(0, attempt=2))
        await eventually(lambda: worker.module._parts.worker._jobs["t-1"].is_cancelled)
        await desk.cancel(attempt=2)
        worker.go.set()
        await given
        await eventually(lambda: len(desk.reports) > 1)
        assert {(r.attempt, r.outcome) for r in desk.reports} == {
            (1, Outcome.KILLED),
            (2, Outcome.KILLED),
        }
        assert worker.begun == [("t-1", 1)]


async def test_a_newer_attempt_does_not_wait_without_end(monkeypatch):
    monkeypatch.setattr("tca_bus._work.SUPERSEDE_PATIENCE", 0.05)
    async with stubborn_shop() as (desk, worker):
        with pytest.raises(BusyError, match="attempt 1 has not stopped yet"):
            await desk.hand(0, attempt=2)
        worker.go.set()
        await eventually(lambda: desk.reports)
        assert worker.begun == [("t-1", 1)]


async def test_only_central_gives_and_stops_tasks():
    async with shop() as (desk, worker), Module("evil", options=desk.module.options) as evil:
        await evil.wait_for(Toil, timeout=10.0)
        fields = {"name": "toil", "task_class": "command", "data": {"number": 0}}
        with pytest.raises(RefusedError, match="only 'central' may order it"):
            await evil.query(HandleTask(id="t-1", attempt=1, sender="x", **fields), to="worker")
        with pytest.raises(RefusedError, match="only 'central' may order it"):
            await evil.query(CancelTask(id="t-1", attempt=1, reason="no"), to="worker")
        assert worker.begun == []


async def test_an_older_attempt_is_refused_while_a_newer_one_runs():
    async with shop() as (desk, worker):
        await desk.hand(0, attempt=2)
        await eventually(lambda: worker.begun)
        with pytest.raises(RefusedError, match="attempt 2 is under way"):
            await desk.hand(0, attempt=1)


async def test_what_cannot_be_handled_is_refused_with_the_reason():
    async with shop() as (desk, _):
        with pytest.raises(NoHandlerError, match="Did you mean 'toil'"):
            await desk.hand(1, name="toll")
        with pytest.raises(InvalidMessageError, match="expected command, got goal"):
            await desk.hand(1, task_class="goal")
        with pytest.raises(InvalidMessageError, match="revision: expected 1, got 9"):
            await desk.hand(1, message_revision=9)
        with pytest.raises(InvalidMessageError, match="number: input should be a valid integer"):
            await desk.hand("many")


async def test_outcomes_wait_for_a_central_that_is_away(monkeypatch):
    monkeypatch.setattr("tca_bus._tasks.TRY_TIMEOUT", 0.2)
    async with shop() as (desk, _):
        desk.is_open.clear()
        await desk.hand(8)
        await eventually(lambda: desk.tries > 1)
        desk.is_open.set()
        await eventually(lambda: desk.reports)
        assert desk.reports[0].result == 16


async def test_an_outcome_that_central_does_not_have_is_not_forgotten(monkeypatch):
    monkeypatch.setattr("tca_bus._outcomes.MOST_REPORTED", 1)
    async with shop(capacity=4) as (desk, worker):
        desk.is_open.clear()
        for number in range(4):
            await desk.hand(number + 1, id=f"t-{number}")
        await eventually(lambda: len(worker.begun) == 4 and not worker.running)
        await desk.hand(1, id="t-0")
        assert len(worker.begun) == 4
        desk.is_open.set()
        await eventually(lambda: {r.id for r in desk.reports} == {"t-0", "t-1", "t-2", "t-3"})


async def test_outcomes_wait_for_a_central_that_is_overrun(monkeypatch, caplog):
    async with shop() as (desk, worker):
        await desk.hand(0)
        await eventually(lambda: worker.begun)
        with monkeypatch.context() as overrun:
            overrun.setattr("tca_bus._tasks.TRY_TIMEOUT", 0.2)
            overrun.setattr("tca_bus._outcomes.REPORT_PATIENCE", 0.2)
            overrun.setattr("tca_bus._serving.MOST_RUNNING", 0)
            worker.go.set()
            await eventually(lambda: "too many waiting" in caplog.text)
        await eventually(lambda: desk.reports)
        assert desk.reports[0].outcome == Outcome.SUCCESS


async def test_outcomes_wait_for_a_central_that_is_started_again():
    async with bus() as options:
        worker, first = Worker(options), Desk(options)
        async with worker.module:
            async with first.module:
                await first.module.wait_for(Toil, timeout=10.0)
                await first.hand(0)
                await eventually(lambda: worker.begun)
            worker.go.set()
            second = Desk(options)
            async with second.module:
                await eventually(lambda: second.reports)
                assert second.reports[0].result == 0


async def test_a_result_of_the_wrong_type_is_a_failure():
    async with bus() as options:
        desk = Desk(options)
        module = Module("worker", options=options)

        @module.handler(Toil)
        async def toil(message, context):
            return "many"

        async with desk.module, module:
            await desk.module.wait_for(Toil, timeout=10.0)
            await desk.hand(1)
            await eventually(lambda: desk.reports)
            failure = desk.reports[0].failure
            assert failure is not None
            assert failure.name == "invalid_result"


async def test_failures_of_children_that_the_handler_saw_are_named():
    async with bus() as options:
        desk = Desk(options)
        module = Module("worker", options=options)

        @module.handler(Plan)
        async def plan(message, context):
            context.saw_failure("child")
            context.saw_failure("child")
            raise TaskFailedError("child", Failure(name="bump", text="contact"))

        async with desk.module, module:
            await desk.module.wait_for(Plan, timeout=10.0)
            await desk.hand(1, name="plan", task_class="goal", data={})
            await eventually(lambda: desk.reports)
            report = desk.reports[0]
            assert report.seen_failures == ("child",)
            assert report.failure is not None
            assert report.failure.name == "bump"
            assert report.failure.cause is not None


async def test_a_module_that_closes_reports_nothing():
    async with bus() as options:
        desk, worker = Desk(options), Worker(options)
        async with desk.module:
            async with worker.module:
                await desk.module.wait_for(Toil, timeout=10.0)
                await desk.hand(0)
                await eventually(lambda: worker.begun)
            assert worker.running == 0
            assert desk.reports == []
