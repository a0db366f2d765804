"""Central on a real bus: tasks that succeed, fail, wait and are killed."""

from __future__ import annotations

import asyncio
import json

import pytest
import zenoh
from central_robot import Deliver, Drive, Quick, office, robot

from tca_bus import (
    Command,
    Constraint,
    Goal,
    HandlerFailedError,
    KilledError,
    Module,
    NoHandlerError,
    RefusedError,
    TaskError,
    TaskFailedError,
    TaskState,
)
from tca_bus._protocol import (
    FindTask,
    KillTask,
    ListTasks,
    Outcome,
    ReadLog,
    ReportOutcome,
    SubmitTask,
)
from tca_bus.testing import central, eventually

pytestmark = pytest.mark.bus


class Chain(Goal[int]):
    """A goal that sends itself below itself, then a quick command."""

    links: int
    number: int


class Tour(Goal[None]):
    """Two steps, of which the second waits."""


class Slow(Command[None]):
    """Runs until it is stopped."""


async def state_of(me, id):
    return (await me.query(FindTask(id=id))).state


async def test_a_command_gives_its_result():
    async with office() as me:
        handle = await me.execute(Quick(number=7))
        assert await handle.result(timeout=10.0) == 7
        assert handle.status.state is TaskState.ACHIEVED


async def test_a_failure_arrives_whole():
    async with office() as me:
        handle = await me.execute(Quick(number=-1))
        with pytest.raises(TaskFailedError, match="-1 is below zero") as caught:
            await handle.result(timeout=10.0)
        failure = caught.value.failure
        assert (failure.name, failure.data) == ("negative", {"by": 1})
        assert (failure.module, failure.node) == ("robot", handle.id)


async def test_a_failure_deep_below_reaches_the_sender_with_its_causes():
    async with office() as me, Module("chain", options=me.options) as chain:

        @chain.handler(Chain, capacity=8)
        async def expand(message, context):
            if message.links:
                await context.expand(Chain(links=message.links - 1, number=message.number))
            else:
                await context.execute(Quick(number=message.number))
            return message.links

        await me.wait_for(Chain, timeout=10.0)
        assert await (await me.expand(Chain(links=3, number=1))).result(timeout=10.0) == 3
        with pytest.raises(TaskFailedError) as caught:
            await (await me.expand(Chain(links=2, number=-1))).result(timeout=10.0)
        names = [link.name for link in caught.value.failure.chain()]
        assert names == ["child_failed", "child_failed", "child_failed", "negative"]


async def test_the_same_id_is_the_same_task_also_when_it_ended():
    async with office() as me:
        first = await me.execute(Quick(number=1), id="same")
        assert await first.result(timeout=10.0) == 1
        again = await me.execute(Quick(number=1), id="same")
        assert await again.result(timeout=10.0) == 1
        log = await me.query(ReadLog(task="same"))
        assert [line.event for line in log].count("submitted") == 1
        with pytest.raises(RefusedError, match="other values of number"):
            await me.execute(Quick(number=2), id="same")


async def test_a_kill_stops_the_handler_and_what_is_below():
    async with office() as me:
        handle = await me.expand(Deliver(there="r-5303", back="r-5313"))
        tasks = []

        async def two_below():
            tasks[:] = await me.query(ListTasks(id=handle.id))
            return len(tasks) == 3 and tasks[1].state is TaskState.ACTIVE

        await eventually(two_below)
        await handle.kill("changed my mind")
        with pytest.raises(KilledError, match="changed my mind"):
            await handle.result(timeout=10.0)
        ended = await me.query(ListTasks(id=handle.id))
        assert {status.state for status in ended[1:]} == {TaskState.KILLED}
        assert await me.query(ListTasks()) == []


async def test_a_kill_that_overtakes_its_task_is_remembered():
    async with office() as me:
        with pytest.raises(HandlerFailedError, match="no task 'early' here") as caught:
            await me.kill("early", reason="no")
        assert caught.value.failure.name == "unknown_task"
        handle = await me.execute(Quick(number=1), id="early")
        with pytest.raises(KilledError):
            await handle.result(timeout=10.0)


async def test_what_nobody_handles_is_refused_with_near_names():
    async with office() as me:
        with pytest.raises(NoHandlerError, match="'quick'"):
            await me.submit_json("quik", {}, task_class="command")
        with pytest.raises(RefusedError, match="root"):
            await me.query(KillTask(id="root"))


async def test_a_task_waits_for_a_handler_for_as_long_as_it_may():
    async with office() as me:
        short = await me.execute(Slow(), wait_for_handler=0.1)
        with pytest.raises(TaskFailedError) as caught:
            await short.result(timeout=10.0)
        assert caught.value.failure.name == "no_handler"
        long = await me.execute(Slow(), wait_for_handler=30.0)
        assert (await me.query(FindTask(id=long.id))).waiting_for == "a module that handles 'slow'"
        async with Module("late", options=me.options) as late:

            @late.handler(Slow)
            async def slow(message, context):
                return None

            assert await long.result(timeout=10.0) is None


async def test_commands_of_one_sender_run_in_order_and_the_next_says_what_it_waits_for():
    async with office() as me:
        first = await me.execute(Drive(to="r-5303"))
        second = await me.execute(Quick(number=2))
        status = await me.query(FindTask(id=second.id))
        assert status.state is TaskState.INACTIVE
        assert status.waiting_for == f"drive {first.id} to be achieved"
        free = await me.execute(Quick(number=3), constraints=Constraint.NONE)
        assert await free.result(timeout=10.0) == 3
        await first.kill("make way")
        assert await second.result(timeout=10.0) == 2


async def test_several_modules_share_the_work():
    async with office() as me, robot("other", me.options):
        await eventually(lambda: len([m for m in me.modules() if "drive" in m.provides]) == 2)
        handles = [
            await me.execute(Drive(to="x"), constraints=Constraint.NONE, wait_for_handler=5.0)
            for _ in range(3)
        ]

        async def states():
            return sorted([await state_of(me, handle.id) for handle in handles])

        async def two_drive():
            return await states() == ["active", "active", "pending"]

        await eventually(two_drive)
        tasks = await me.query(ListTasks())
        assert {task.handler for task in tasks if task.handler} == {"robot", "other"}


async def test_a_module_handles_as_many_at_once_as_it_says():
    async with office() as me, Module("slow", options=me.options) as slow:

        @slow.handler(Slow, capacity=3)
        async def run(message, context):
            await asyncio.Event().wait()

        await me.wait_for(Slow, timeout=10.0)
        handles = [await me.execute(Slow(), constraints=Constraint.NONE) for _ in range(4)]

        async def three_run():
            states = [await state_of(me, handle.id) for handle in handles]
            return states.count(TaskState.ACTIVE) == 3

        await eventually(three_run)


async def test_data_that_do_not_fit_fail_the_task():
    async with office() as me:
        handle = await me.submit_json("quick", {"number": "x"}, task_class="command")
        with pytest.raises(TaskFailedError, match="number") as caught:
            await handle.result(timeout=10.0)
        assert caught.value.failure.name == "invalid_message"


async def test_a_sender_cannot_speak_for_another():
    async with office() as me:
        task = SubmitTask(id="x", name="quick", task_class="command", data={}, sender="rogue")
        with pytest.raises(RefusedError, match="comes from 'me'"):
            await me.query(task)


async def test_a_module_reports_only_what_it_handles_itself():
    async with office() as me:
        handle = await me.execute(Drive(to="r-5303"))
        report = ReportOutcome(id=handle.id, attempt=1, outcome=Outcome.SUCCESS)
        with pytest.raises(RefusedError, match="module 'robot' handles it, not 'me'"):
            await me.query(report)
        assert not (await me.query(FindTask(id=handle.id))).is_ended


async def test_a_plain_zenoh_client_sees_the_tasks():
    def look(endpoint, key):
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", json.dumps([endpoint]))
        config.insert_json5("scouting/multicast/enabled", "false")
        with zenoh.open(config) as session:
            replies = list(session.get(key))
            return {
                str(reply.ok.key_expr): json.loads(reply.ok.payload.to_string())
                for reply in replies
                if reply.ok
            }

    async with office() as me:
        done = await me.execute(Quick(number=1))
        await done.result(timeout=10.0)
        drive = await me.execute(Drive(to="r-5303"))
        prefix = f"{me.options.realm}/task"
        seen = await asyncio.to_thread(look, me.options.connect, f"{prefix}/**")
        assert seen[f"{prefix}/me/{done.id}"]["state"] == "achieved"
        assert seen[f"{prefix}/me/{drive.id}"]["data"] == {"to": "r-5303"}
        one = f"{prefix}/me/{drive.id}"
        assert list(await asyncio.to_thread(look, me.options.connect, one)) == [one]
        by_id = f"{me.options.realm}/**/{drive.id}"
        assert list(await asyncio.to_thread(look, me.options.connect, by_id)) == [one]


async def test_changes_are_published():
    async with office() as me, me.watch_statuses() as changes:
        handle = await me.execute(Quick(number=1))
        states = []
        async for status in changes:
            if status.id == handle.id:
                states.append(status.state)
            if status.is_ended:
                break
        assert states[-1] is TaskState.ACHIEVED


async def test_a_second_central_is_refused():
    async with office() as me:
        with pytest.raises(RefusedError, match="is central there"):
            async with central(me.options):
                pass
        assert await (await me.execute(Quick(number=1))).result(timeout=10.0) == 1


async def test_a_parent_that_saw_a_failure_goes_on():
    async with office() as me, Module("chain", options=me.options) as chain:

        @chain.handler(Chain)
        async def expand(message, context):
            child = await context.execute(Quick(number=-1))
            try:
                await child.result(timeout=10.0)
            except TaskFailedError:
                return 1
            raise TaskError("surprise", "it should have failed")

        await me.wait_for(Chain, timeout=10.0)
        handle = await me.expand(Chain(links=0, number=0))
        assert await handle.result(timeout=10.0) == 1


async def test_what_ended_below_a_living_task_is_listed_with_it():
    async with office() as me, Module("guide", options=me.options) as guide:
        release = asyncio.Event()

        @guide.handler(Tour)
        async def tour(_, context):
            await (await context.execute(Quick(number=1), id="first")).result()
            await release.wait()

        await me.wait_for(Tour, timeout=10.0)
        handle = await me.expand(Tour(), id="tour")

        async def listed(**question):
            return [(task.id, task.state) for task in await me.query(ListTasks(**question))]

        async def is_listed():
            return await listed(id="tour") == both

        both = [("tour", "active"), ("first", "achieved")]
        await eventually(is_listed)
        assert await listed(ended=True) == both
        assert await listed() == both[:1]
        release.set()
        await handle.result(timeout=10.0)
