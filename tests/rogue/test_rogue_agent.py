"""The agent as a whole, with a robot that answers at once."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from rogue_fakes import PLACES, FakeModule, HangingRobot, ScriptedRobot

from rogue.agent import Agent, AgentOptions
from rogue.memory import Store
from rogue.messages import DeliveryRequest, ListRequests, PostRequest, ReadTrace, ShowPlan
from rogue.requests import load_directory
from rogue.trace import LISTENING
from tca_bus.testing import eventually

POST = PostRequest(id="a", user="mitchell", item="delivermail")


@asynccontextmanager
async def running(
    folder: Path, robot: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[FakeModule]:
    async def rooms(*, patience: float | None = None) -> dict[str, tuple[float, float]]:
        del patience
        return {room: (x / 100, y / 100) for room, (x, y) in PLACES.items()}

    robot.rooms = rooms
    monkeypatch.setattr("rogue.agent.BusRobot", lambda module, endurance: robot)
    module = FakeModule()
    async with Store(folder) as store:
        agent = Agent(module, store, load_directory(), AgentOptions(folder=folder))
        await agent.load()
        agent.open_desk()
        module.start(agent.run(), name="agent")
        try:
            yield module
        finally:
            for task in module.tasks:
                task.cancel()
            await asyncio.gather(*module.tasks, return_exceptions=True)


async def requests(module: FakeModule) -> list[DeliveryRequest]:
    found = await module.ask(ListRequests())
    assert isinstance(found, list)
    return found


async def reaches(module: FakeModule, state: str) -> DeliveryRequest:
    async def is_there() -> bool:
        return [r.state.value for r in await requests(module)] == [state]

    await eventually(is_there, what=f"the request to be {state}")
    return (await requests(module))[0]


async def listens(module: FakeModule, *, times: int) -> None:
    async def has_said_so() -> bool:
        lines = await module.ask(ReadTrace())
        return [line.text for line in lines].count(LISTENING) == times

    await eventually(has_said_so, what="the agent to listen")


async def test_a_request_is_served_and_the_agent_listens_on(tmp_path, monkeypatch):
    async with running(tmp_path, ScriptedRobot(), monkeypatch) as module:
        await listens(module, times=1)
        await module.ask(POST)
        await reaches(module, "completed")
        await listens(module, times=2)
        plan = await module.ask(ShowPlan())
        assert not plan.planning
        assert plan.executed[0] == "<GOTO-PICKUP-LOC MITCHELL R-5303>"
        assert plan.tree.status == "solved"
        assert [step.text for step in plan.tree.steps] == [one.lower() for one in plan.executed]


async def test_at_its_deadline_a_request_has_failed(tmp_path, monkeypatch):
    robot = HangingRobot()
    async with running(tmp_path, robot, monkeypatch) as module:
        await module.ask(POST)
        await robot.driving.wait()
        await module.clock.advance(3599.0)
        assert (await requests(module))[0].state.value == "underway"
        await module.clock.advance(2.0)
        failed = await reaches(module, "failed")
        assert failed.reason is not None
        assert failed.reason.startswith("its deadline, ")
        await eventually(lambda: robot.killed, what="the drive to be broken off")


async def test_a_restarted_agent_goes_on_where_it_was(tmp_path, monkeypatch):
    robot = HangingRobot()
    async with running(tmp_path, robot, monkeypatch) as module:
        await module.ask(POST)
        await robot.driving.wait()
    robot = ScriptedRobot()
    async with running(tmp_path, robot, monkeypatch) as module:
        await reaches(module, "completed")
        assert robot.ids[0].endswith("-1.4")
