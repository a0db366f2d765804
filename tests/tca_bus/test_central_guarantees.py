"""What central guarantees when its journal is slow or full and modules come and go."""

from __future__ import annotations

import asyncio

import pytest
from central_robot import Drive, Quick, office, robot

from tca_bus import (
    Command,
    Constraint,
    Module,
    NoHandlerError,
    TaskError,
    TaskFailedError,
    TaskState,
    TimedOutError,
)
from tca_bus._journal import Journal, JournalError
from tca_bus._parts import Parts
from tca_bus._protocol import Describe, FindTask, KillTask, SubmitTask
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


class Slow(Command[None]):
    """Runs until it is stopped."""


async def state_of(me, id):
    return (await me.query(FindTask(id=id))).state


async def test_a_module_that_was_taken_for_lost_stops_what_it_was_relieved_of():
    async with (
        bus() as options,
        central(options),
        robot("robot", options) as module,
        Module("me", options=options) as me,
    ):
        await me.wait_for(Drive, "tca.submit", timeout=10.0)
        handle = await me.execute(Drive(to="r-5303"))
        await eventually(module._parts.worker.handling)
        module._parts._token.undeclare()
        with pytest.raises(TaskFailedError) as caught:
            await handle.result(timeout=10.0)
        assert caught.value.failure.name == "module_lost"
        assert module._parts.worker.handling()
        module._parts._token, module._parts._announced = None, ""
        module._parts.announce()
        await eventually(lambda: not module._parts.worker.handling())
        quick = await me.execute(Quick(number=1), wait_for_handler=5.0)
        assert await quick.result(timeout=10.0) == 1


async def test_a_module_is_asked_again_until_it_introduces_itself(monkeypatch):
    describe = Parts._describe
    tries = []

    async def describe_later(self, question, context):
        tries.append(self.core.name)
        if tries.count("slow") == 1:
            raise TaskError("not_yet", "one moment")
        return await describe(self, question, context)

    monkeypatch.setattr(Parts, "_describe", describe_later)
    monkeypatch.setattr("tca_bus._central.INTRODUCTION_DELAY", 0.05)
    async with office() as me, Module("slow", options=me.options) as slow:

        @slow.handler(Slow, capacity=2)
        async def run(message, context):
            await asyncio.Event().wait()

        await me.wait_for(Slow, timeout=10.0)
        handles = [
            await me.execute(Slow(), constraints=Constraint.NONE, wait_for_handler=5.0)
            for _ in range(2)
        ]

        async def both_run():
            return {await state_of(me, handle.id) for handle in handles} == {TaskState.ACTIVE}

        await eventually(both_run)


async def test_an_end_is_told_only_once_it_is_in_the_journal(monkeypatch):
    write, ending, gate = Journal.write, asyncio.Event(), asyncio.Event()
    order = []

    async def write_late(self, records, finals, ended):
        if finals:
            ending.set()
            await gate.wait()
            order.append("written")
        await write(self, records, finals, ended)

    monkeypatch.setattr(Journal, "write", write_late)
    async with office() as me, asyncio.TaskGroup() as group:
        await me.execute(Quick(number=1), id="same")
        await ending.wait()

        async def tell(question):
            assert (await question).is_ended
            order.append("told")

        again = SubmitTask(
            id="same", name="quick", task_class="command", sender="me", data={"number": 1}
        )
        for question in (again, KillTask(id="same"), FindTask(id="same")):
            group.create_task(tell(me.query(question)))
        for _ in range(3):
            await me.query(Describe(), to="central")
        gate.set()
    assert order == ["written", "told", "told", "told"]


async def serve_with_a_full_disk(options, me, monkeypatch):
    """Serve a task that cannot be written; gives its sending, which must not succeed."""

    async def refuse(*_):
        raise JournalError("central.db", "the disk is full")

    async with central(options):
        await me.wait_for("quick", "tca.submit", timeout=10.0)
        monkeypatch.setattr("tca_bus._journal.Journal.write", refuse)
        me.start(expect_no_acknowledgement(me), name="sending")
        await asyncio.Event().wait()


async def expect_no_acknowledgement(me):
    with pytest.raises((NoHandlerError, TimedOutError)):
        await me.execute(Quick(number=1), timeout=2.0)


async def test_a_journal_that_cannot_be_written_ends_central_before_it_acknowledges(monkeypatch):
    async with bus() as options, robot("robot", options), Module("me", options=options) as me:
        with pytest.raises(JournalError, match="the disk is full"):
            await serve_with_a_full_disk(options, me, monkeypatch)
        await eventually(lambda: "sending" not in {task.get_name() for task in asyncio.all_tasks()})
