"""Answers (tca.md 3.1 and 3.4): postponed ones, from anywhere in the module."""

from __future__ import annotations

import asyncio

import pytest
from tree_robot import Robot

from tca_bus import Command, KilledError, Module, TaskContext, TaskError, TaskFailedError
from tca_bus.testing import eventually


@pytest.mark.bus
async def test_a_postponed_answer_ends_the_task_when_it_comes(user: Module, robot: Robot):
    class Ask(Command[str]):
        """Answered later."""

    asked: list[str] = []

    async def ask(_: Ask, ctx: TaskContext) -> None:
        ctx.postpone()
        asked.append(ctx.id)

    robot.module.serve(Ask, ask, capacity=2)
    await user.wait_for(Ask, timeout=10.0)
    task = await user.execute(Ask())
    await eventually(lambda: asked)
    assert not task.status.is_ended
    await eventually(lambda: not _is_answered(robot.module, asked[0], "later"))
    assert await task.result(timeout=10.0) == "later"
    with pytest.raises(TaskError, match="waits for no answer"):
        robot.module.answer(asked[0], "again")


def _is_answered(module: Module, task: str, result: str) -> bool:
    try:
        module.answer(task, result)
    except TaskError:
        return True
    return False


class Later(Command[str]):
    """Answered later, or not at all."""


async def postponed(user: Module, robot: Robot) -> asyncio.Queue[str]:
    asked: asyncio.Queue[str] = asyncio.Queue()

    async def later(_: Later, ctx: TaskContext) -> None:
        ctx.postpone()
        asked.put_nowait(ctx.id)

    robot.module.serve(Later, later)
    await user.wait_for(Later, timeout=10.0)
    return asked


@pytest.mark.bus
async def test_a_postponed_answer_may_be_a_failure(user: Module, robot: Robot):
    asked = await postponed(user, robot)
    task = await user.execute(Later())
    robot.module.answer_failure(await asked.get(), TaskError("no_idea", "I am new here"))
    with pytest.raises(TaskFailedError, match="I am new here") as failed:
        await task.result(timeout=10.0)
    assert failed.value.failure.name == "no_idea"


@pytest.mark.bus
async def test_a_postponed_task_can_be_killed(user: Module, robot: Robot):
    asked = await postponed(user, robot)
    task = await user.execute(Later())
    id = await asked.get()
    await task.kill("nobody answers")
    with pytest.raises(KilledError):
        await task.result(timeout=10.0)
    with pytest.raises(TaskError, match="waits for no answer"):
        robot.module.answer(id, "too late")


@pytest.mark.bus
async def test_a_postponed_task_keeps_its_place_in_the_capacity(user: Module, robot: Robot):
    asked = await postponed(user, robot)
    first = await user.execute(Later(), constraints=0)
    second = await user.execute(Later(), constraints=0)
    id = await asked.get()
    assert second.status.state == "pending"
    assert asked.empty()
    robot.module.answer(id, "first")
    robot.module.answer(await asked.get(), "second")
    assert await first.result(timeout=10.0) == "first"
    assert await second.result(timeout=10.0) == "second"
