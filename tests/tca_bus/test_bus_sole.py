"""Modules that do not share their name."""

from __future__ import annotations

import asyncio

import pytest

from tca_bus import Module, Query, RefusedError
from tca_bus.testing import bus, eventually

pytestmark = pytest.mark.bus


class Who(Query[str]):
    wire_name = "who"


def robot(options):
    module = Module("robot", options=options, sole=True)

    @module.handler(Who)
    async def answer(message, context):
        return module.incarnation

    return module


async def keep(module):
    async with module:
        await module.serve_forever()


def robots(me):
    return [one.incarnation for one in me.modules() if one.name == "robot"]


async def test_a_second_is_refused_and_never_answers():
    async with bus() as options, robot(options) as first, Module("me", options=options) as me:
        with pytest.raises(RefusedError, match=r"a second robot on realm .* is robot there; stop"):
            async with robot(options):
                pass
        assert await me.query(Who()) == first.incarnation


async def test_the_next_one_is_taken_when_the_first_has_left():
    async with bus() as options, Module("me", options=options) as me:
        async with robot(options) as first:
            await me.wait_for(Who, timeout=10.0)
            entering = asyncio.create_task(keep(robot(options)))
        await eventually(lambda: len(robots(me)) == 1 and robots(me) != [first.incarnation])
        assert [await me.query(Who())] == robots(me)
        entering.cancel()
        await asyncio.wait({entering})


async def test_of_many_that_start_at_once_one_stays():
    async with bus() as options, Module("me", options=options) as me:
        modules = [robot(options) for _ in range(4)]
        tasks = {asyncio.create_task(keep(module), name=module.incarnation) for module in modules}
        gone, stayed = set[asyncio.Task[None]](), tasks
        while len(stayed) > 1:
            done, stayed = await asyncio.wait(stayed, return_when=asyncio.FIRST_COMPLETED)
            gone |= done
        assert {type(task.exception()) for task in gone} == {RefusedError}
        (only,) = stayed
        await eventually(lambda: robots(me) == [only.get_name()])
        assert await me.query(Who()) == only.get_name()
        only.cancel()
        await asyncio.wait(tasks)


async def test_modules_that_are_not_sole_may_share_a_name():
    async with (
        bus() as options,
        Module("watcher", options=options) as one,
        Module("watcher", options=options) as other,
    ):
        await eventually(lambda: len(one.modules()) == len(other.modules()) == 2)
