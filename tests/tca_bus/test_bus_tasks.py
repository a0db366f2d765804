"""Goals and commands through the real central."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest
from bus_process import victim
from bus_victim import Retoil, Toil
from mortal_router import MortalRouter
from pydantic import BaseModel

from tca_bus import (
    Command,
    Constraint,
    Goal,
    InvalidMessageError,
    KilledError,
    Module,
    NoHandlerError,
    RefusedError,
    TaskError,
    TaskFailedError,
    TaskState,
    TaskStatus,
    TimedOutError,
)
from tca_bus._central import Central
from tca_bus._presence import VANISH_GRACE
from tca_bus._protocol import SubmitTask
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


@pytest.fixture(autouse=True)
def _short_grace(monkeypatch):
    monkeypatch.setattr("tca_bus._central.RETURN_GRACE", 2 * VANISH_GRACE)


class Parcel(BaseModel):
    weight: float


class Carry(Command[Parcel]):
    weight: float


class Deliver(Goal[str]):
    weights: list[float]


def porter(options, gate=None):
    """Carries what is not too heavy; with a gate it waits there."""
    module = Module("porter", options=options)
    seen: list[str] = []

    @module.handler(Carry)
    async def carry(message, context):
        seen.append(context.id)
        if gate is not None:
            await gate.wait()
        if message.weight > 10:
            raise TaskError("too_heavy", "it is too heavy", data=Parcel(weight=message.weight))
        return Parcel(weight=message.weight)

    @module.handler(Deliver)
    async def deliver(message, context):
        told = []
        for number, weight in enumerate(message.weights):
            child = await context.execute(Carry(weight=weight), id=f"{context.id}.{number}")
            try:
                told.append(str((await child.result()).weight))
            except TaskFailedError as error:
                told.append(error.failure.name)
        return " ".join(told)

    return module, seen


@asynccontextmanager
async def office(gate=None, data=None):
    async with bus() as options, central(options, data=data):
        module, seen = porter(options, gate)
        async with module, Module("boss", options=options) as boss:
            await boss.wait_for(Carry, Deliver, timeout=10.0)
            yield options, boss, seen


async def test_a_command_gives_the_result_that_it_names():
    async with office() as (_, boss, _):
        handle = await boss.execute(Carry(weight=2.5))
        assert await handle.result(timeout=10.0) == Parcel(weight=2.5)
        assert handle.status.state == TaskState.ACHIEVED
        assert handle.status.handler == "porter"
        plain = await boss.submit_json("carry", {"weight": 1}, task_class="command")
        assert await plain.result(timeout=10.0) == {"weight": 1.0}


def central_sees_late(monkeypatch, times):
    """Let central not see the handler the first ``times``; gives the tasks that it refused."""
    admit, refused = Central.admit, []

    async def admit_late(self, task):
        if len(refused) < times:
            refused.append(task.id)
            raise NoHandlerError(task.name)
        await admit(self, task)

    monkeypatch.setattr(Central, "admit", admit_late)
    return refused


async def test_a_handler_that_central_sees_after_the_sender_is_no_missing_one(monkeypatch):
    refused = central_sees_late(monkeypatch, 2)
    async with office() as (_, boss, seen):
        handle = await boss.execute(Carry(weight=2.5), id="early")
        assert await handle.result(timeout=10.0) == Parcel(weight=2.5)
    assert refused == ["early", "early"]
    assert seen == ["early"]


async def test_a_handler_that_central_does_not_see_is_missing_in_the_end(monkeypatch):
    monkeypatch.setattr("tca_bus._tasks.SIGHT_DELAY", 0.2)
    refused = central_sees_late(monkeypatch, 1000)
    async with office() as (_, boss, _):
        with pytest.raises(NoHandlerError, match="'carry'"):
            await boss.execute(Carry(weight=2.5))
        assert len(refused) == 2
        with pytest.raises(NoHandlerError, match="'fly'"):
            await boss.submit_json("fly", {}, task_class="command")
        assert len(refused) == 3


async def test_a_failure_crosses_with_name_text_data_and_node():
    async with office() as (_, boss, _):
        handle = await boss.execute(Carry(weight=99.0))
        with pytest.raises(TaskFailedError) as caught:
            await handle.result(timeout=10.0)
        failure = caught.value.failure
        assert (failure.name, failure.data) == ("too_heavy", {"weight": 99.0})
        assert (failure.node, failure.module) == (handle.id, "porter")


async def test_a_goals_handler_makes_children_and_may_cope_with_their_failures():
    async with office() as (_, boss, seen):
        handle = await boss.expand(Deliver(weights=[1.0, 99.0, 2.0]), id="round")
        assert await handle.result(timeout=10.0) == "1.0 too_heavy 2.0"
        assert seen == ["round.0", "round.1", "round.2"]


async def test_the_same_id_is_the_same_node_also_after_it_ended():
    async with office() as (_, boss, seen):
        first = await boss.execute(Carry(weight=1.0), id="once")
        second = await boss.execute(Carry(weight=1.0), id="once")
        assert await first.result(timeout=10.0) == await second.result(timeout=10.0)
        third = await boss.execute(Carry(weight=1.0), id="once")
        assert await third.result(timeout=10.0) == Parcel(weight=1.0)
        assert seen == ["once"]
        with pytest.raises(RefusedError):
            await boss.execute(Carry(weight=2.0), id="once")


async def test_a_killed_task_ends_its_handler_and_raises_killed():
    async with office(asyncio.Event()) as (_, boss, seen):
        handle = await boss.execute(Carry(weight=1.0))
        await eventually(lambda: seen)
        await handle.kill("no longer wanted")
        with pytest.raises(KilledError, match="no longer wanted"):
            await handle.result(timeout=10.0)


async def test_what_cannot_be_is_refused_when_it_is_sent():
    async with office() as (_, boss, _):
        with pytest.raises(NoHandlerError, match="Did you mean 'carry'"):
            await boss.submit_json("cary", {}, task_class="command")
        with pytest.raises(InvalidMessageError, match="id"):
            await boss.execute(Carry(weight=1.0), id="two words")
        unfit = await boss.submit_json("carry", {"weight": "much"}, task_class="command")
        with pytest.raises(TaskFailedError, match="weight: input should be a valid number"):
            await unfit.result(timeout=10.0)


async def test_a_result_that_does_not_come_in_time_is_a_timeout_and_may_be_awaited_again():
    gate = asyncio.Event()
    async with office(gate) as (_, boss, _):
        handle = await boss.execute(Carry(weight=1.0))
        with pytest.raises(TimedOutError):
            await handle.result(timeout=0.05)
        gate.set()
        assert await handle.result(timeout=10.0) == Parcel(weight=1.0)


async def test_without_central_sending_says_so(monkeypatch):
    monkeypatch.setattr("tca_bus._tasks.UNSEEN_GRACE", 0.2)
    async with bus() as options, Module("boss", options=options) as boss:
        with pytest.raises(NoHandlerError, match="central"):
            await boss.execute(Carry(weight=1.0))


async def test_a_task_lives_through_a_restart_of_central(tmp_path):
    gate = asyncio.Event()
    async with bus() as options:
        module, seen = porter(options, gate)
        async with module, Module("boss", options=options) as boss:
            async with central(options, data=tmp_path):
                await boss.wait_for(Carry, "tca.submit", timeout=10.0)
                handle = await boss.execute(Carry(weight=1.0))
                await eventually(lambda: seen)
            gate.set()
            waiting = asyncio.create_task(handle.result(timeout=30.0))
            async with central(options, data=tmp_path):
                assert await waiting == Parcel(weight=1.0)
        assert len(seen) == 1


async def test_a_task_that_central_has_forgotten_is_a_failure():
    async with bus() as options, Module("boss", options=options) as boss:
        module, seen = porter(options, asyncio.Event())
        async with module:
            async with central(options):
                await boss.wait_for(Carry, "tca.submit", timeout=10.0)
                handle = await boss.execute(Carry(weight=1.0))
                await eventually(lambda: seen)
            async with central(options):
                with pytest.raises(TaskFailedError) as caught:
                    await handle.result(timeout=20.0)
                assert caught.value.failure.name == "unknown_task"


async def test_a_task_lives_through_a_restart_of_the_router():
    gate = asyncio.Event()
    async with MortalRouter() as router, central(router.options):
        module, seen = porter(router.options, gate)
        async with module, Module("boss", options=router.options) as boss:
            await boss.wait_for(Carry, timeout=10.0)
            handle = await boss.execute(Carry(weight=1.0))
            waiting = asyncio.create_task(handle.result(timeout=30.0))
            await eventually(lambda: seen)
            await router.die()
            await eventually(lambda: not boss.is_connected)
            gate.set()
            await router.rise()
            assert await waiting == Parcel(weight=1.0)
            assert len(seen) == 1


async def test_a_task_whose_module_is_killed_fails_or_goes_to_the_next():
    async with bus() as options, central(options), Module("boss", options=options) as boss:
        async with victim(options) as process:
            await boss.wait_for(Toil, timeout=20.0)
            lost = await boss.execute(Toil())
            again = await boss.execute(Retoil(), constraints=Constraint.NONE)
            await eventually(lambda: lost.status.state == again.status.state == TaskState.ACTIVE)
            process.kill()
            with pytest.raises(TaskFailedError) as caught:
                await lost.result(timeout=10.0)
            assert caught.value.failure.name == "module_lost"
        relief = Module("relief", options=options)

        @relief.handler(Retoil)
        async def toil(message, context):
            return context.attempt

        async with relief:
            assert await again.result(timeout=10.0) == 2


async def test_a_state_that_is_published_before_the_acknowledgement_arrives_is_not_lost():
    async with bus() as options:
        quick, boss = Module("central", options=options), Module("boss", options=options)
        acknowledged = asyncio.Event()

        @quick.handler(SubmitTask)
        async def submit(task, context):
            quick.publish_status(status_of(task, TaskState.ACTIVE, 2))
            await acknowledged.wait()
            return status_of(task, TaskState.PENDING, 1)

        async with quick, boss, boss.watch_statuses() as states:
            await boss.wait_for(SubmitTask, timeout=10.0)
            sending = asyncio.create_task(boss.execute(Carry(weight=1.0)))
            assert (await states.get()).state == TaskState.ACTIVE
            acknowledged.set()
            handle = await sending
            await eventually(lambda: handle.status.state == TaskState.ACTIVE)


def status_of(task, state, sequence):
    return TaskStatus(
        id=task.id,
        name=task.name,
        task_class="command",
        sender=task.sender,
        parent=None,
        state=state,
        handling="handling",
        planning="planned",
        achievement="achieving",
        existence="alive",
        created=0.0,
        sequence=sequence,
    )
