"""Handlers' resources on a real bus: shared by handlers, locked, reserved, waited for."""

from __future__ import annotations

import asyncio
import logging

import pytest
from resource_office import (
    Arm,
    Grasp,
    Nested,
    Nudge,
    Touch,
    Trip,
    Wave,
    armed,
    asked,
    holders,
    resource,
    waiters,
    waiting,
)

from tca_bus import (
    ConfigError,
    InvalidMessageError,
    Module,
    RefusedError,
    TaskFailedError,
)
from tca_bus._protocol import FindTask
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


async def test_handlers_in_one_resource_exclude_each_other():
    async with armed() as (one, two, arm):
        tasks = [
            await one.execute(Grasp()),
            await two.execute(Wave()),
            await one.execute(Grasp(), constraints=0),
        ]
        await eventually(lambda: arm.inside == 1)
        listed = await resource(one, "robot/arm")
        assert listed.messages == ("grasp", "wave")
        assert len(listed.holders) == 1
        assert len(listed.waiters) == 2
        assert listed.waiters[0].waiting_for == "robot, which has 1 in its resource 'arm'"
        arm.open.set()
        assert [await task.result(timeout=10.0) for task in tasks] == ["done"] * 3
        assert arm.most == 1


async def test_queries_and_informs_take_their_turn_in_a_resource():
    async with armed() as (one, two, arm):
        await one.execute(Grasp())
        await eventually(lambda: arm.inside == 1)
        asked = asyncio.ensure_future(two.query(Touch()))
        await one.inform(Nudge())
        await eventually(lambda: arm.in_line == 2)
        assert await arm.module.query(Touch()) == 1
        assert not asked.done()
        assert arm.nudged == 0
        arm.open.set()
        assert await asyncio.wait_for(asked, 10.0) == 0
        await eventually(lambda: arm.nudged == 1)


async def test_of_too_many_tasks_the_oldest_fails():
    async with armed(pending=1) as (one, two, arm):
        await one.execute(Grasp())
        await eventually(lambda: arm.inside == 1)
        first = await two.execute(Wave())
        second = await one.execute(Wave(), constraints=0)
        with pytest.raises(TaskFailedError) as caught:
            await first.result(timeout=10.0)
        assert caught.value.failure.name == "pending_limit"
        assert caught.value.failure.data == {"resource": "robot/arm", "limit": 1}
        assert (await resource(one, "robot/arm")).dropped == 1
        arm.open.set()
        assert await second.result(timeout=10.0) == "done"


async def test_a_lock_waits_for_handlers_and_keeps_others_out():
    async with armed() as (one, two, arm):
        running = await one.execute(Grasp())
        await eventually(lambda: arm.inside == 1)

        async def take():
            return await two.lock("arm")

        locking = asyncio.ensure_future(take())
        await eventually(lambda: waiters(one, "robot/arm"))
        later = await one.execute(Wave(), constraints=0)
        arm.open.set()
        assert await running.result(timeout=10.0) == "done"
        lock = await asyncio.wait_for(locking, 10.0)
        assert lock.names == ("arm",)
        status = await resource(one, "robot/arm")
        assert [user.kind for user in status.holders] == ["lock"]
        assert status.waiters[0].waiting_for == "robot, which is held by two, who has a lock"
        assert later.status.state == "pending"
        await lock.release()
        assert await later.result(timeout=10.0) == "done"


async def test_a_reservation_passes_the_reservers_messages_only():
    async with armed() as (one, two, arm):
        arm.open.set()
        async with one.reserve("robot/arm"):
            mine = await one.execute(Grasp())
            assert await mine.result(timeout=10.0) == "done"
            theirs = await two.execute(Grasp())
            again = await one.execute(Grasp(), constraints=0)
            assert await again.result(timeout=10.0) == "done"
            assert (await two.query(FindTask(id=theirs.id))).state == "pending"
            with pytest.raises(RefusedError, match="has a reservation of it already"):
                await one.reserve("robot/arm")
        assert await theirs.result(timeout=10.0) == "done"


async def test_a_lock_outlives_central_and_ends_with_its_module(tmp_path):
    async with bus() as options, Module("two", options=options) as two:
        arm = Arm(options)
        arm.open.set()
        async with arm.module, Module("one", options=options) as one:
            async with central(options, data=tmp_path):
                await eventually(lambda: asked(two, "robot/arm"))
                await one.lock("robot/")
            async with central(options, data=tmp_path):
                await eventually(lambda: asked(two, "robot/arm"))
                assert await holders(two, "robot/") == ["one"]
                task = await two.execute(Grasp())
                assert task.status.state == "pending"
                await one.__aexit__(None, None, None)
                assert await task.result(timeout=10.0) == "done"


async def test_a_lock_of_what_nobody_has_is_refused():
    async with armed() as (one, _two, _arm):
        with pytest.raises(RefusedError, match=r"Did you mean 'robot/arm'"):
            await one.lock("robot/arn")
        with pytest.raises(RefusedError, match="reserve or lock it instead"):
            await one.acquire("robot/arm")
        with pytest.raises(InvalidMessageError, match="names"):
            await one.acquire("no such name")


async def test_a_short_name_that_several_have_is_refused():
    async with armed() as (one, _two, _arm), Arm(one.options, name="other").module:
        await eventually(lambda: resource(one, "other/arm"))
        with pytest.raises(RefusedError, match="several: other/arm, robot/arm"):
            await one.lock("arm")


async def test_a_lease_kept_by_a_goal_lasts_until_all_below_it_has_ended():
    async with armed() as (one, two, arm):
        trip = await one.expand(Trip(thing="lift"))
        await eventually(lambda: arm.inside == 1)
        later = waiting(two, "lift")
        await eventually(lambda: waiters(one, "lift"))
        (user,) = (await resource(one, "lift")).holders
        assert user.task == trip.id
        arm.open.set()
        await trip.result(timeout=10.0)
        assert (await asyncio.wait_for(later, 10.0)).is_held


async def test_a_handler_that_awaits_one_of_itself_is_reported(caplog):
    async with armed() as (one, _two, _arm):
        caplog.set_level(logging.WARNING)
        task = await one.execute(Nested(depth=1))

        async def rings():
            return (await resource(one, "robot/nested")).cycles

        await eventually(rings)
        (ring,) = await rings()
        assert task.id in ring
        assert caplog.text.count("wait for each other for ever") == 1
        await task.kill("it would never end")


async def test_resources_of_a_module_are_checked_where_they_are_made():
    module = Module("robot")
    module.resource("arm", capacity=2)
    with pytest.raises(ConfigError, match="has not given yet"):
        module.resource("arm")
    with pytest.raises(ConfigError, match="at least 1"):
        module.resource("leg", capacity=0)
    with pytest.raises(ConfigError, match="Did you mean 'arm'"):
        module.serve(Grasp, _noop, resource="arn")
    with pytest.raises(ConfigError, match="none for a handler in resource 'arm'"):
        module.serve(Grasp, _noop, resource="arm", capacity=3)
    with pytest.raises(ConfigError, match="no goal or command"):
        module.serve(Touch, _noop, pending=3)


async def _noop(_message, _context):
    return None
