"""The agent as a whole, with a robot that answers at once."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from rogue_fakes import PLACES, FakeModule, HangingRobot, ScriptedRobot

from navigate.messages import NavigateToGoal
from rogue.agent import Agent, AgentOptions
from rogue.execution import TaskOfRobot, Urgency
from rogue.memory import Store
from rogue.messages import (
    CancelRequest,
    DeliveryRequest,
    ListRequests,
    PostRequest,
    ReadTrace,
    ShowPlan,
)
from rogue.outcomes import Outcome
from rogue.requests import load_directory
from rogue.trace import LISTENING
from tca_bus.testing import eventually
from xavier_sim.messages import DoorState, WorldDoors

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


async def test_a_deadline_that_passes_at_a_closed_door_names_the_door(tmp_path, monkeypatch):
    async with running(tmp_path, ScriptedRobot(), monkeypatch) as module:
        module.answers[WorldDoors] = [DoorState(room="r-5303", open=False)]
        await module.ask(POST.model_copy(update={"deadline": "+5min"}))
        await reaches(module, "queued")

        async def is_put_off() -> bool:
            return "a is put off" in "".join(line.text for line in await module.ask(ReadTrace()))

        await eventually(is_put_off)
        await module.clock.advance(301.0)
        failed = await reaches(module, "failed")
    assert failed.reason is not None
    assert failed.reason.endswith("passed before it was done: the door of r-5303 is closed")


class StuckRobot(ScriptedRobot):
    """A robot that drives once, and then gets stuck until the drive is broken off."""

    def __init__(self) -> None:
        super().__init__()
        self.stuck = asyncio.Event()

    async def perform(self, task_id: str, message: TaskOfRobot, urgency: Urgency) -> Outcome:
        outcome = await super().perform(task_id, message, urgency)
        if self.count(NavigateToGoal) == 2 and isinstance(message, NavigateToGoal):
            self.stuck.set()
            await asyncio.get_running_loop().create_future()
        return outcome


async def test_at_the_deadline_what_is_on_the_tray_goes_back(tmp_path, monkeypatch):
    robot = StuckRobot()
    async with running(tmp_path, robot, monkeypatch) as module:
        await module.ask(POST)
        await robot.stuck.wait()
        await module.clock.advance(3601.0)
        failed = await reaches(module, "failed")
    assert failed.reason is not None
    assert failed.reason.startswith("its deadline, ")
    assert failed.reason.endswith("; the item is back in r-5303")


async def test_what_is_canceled_on_the_way_is_delivered_if_the_user_says_so(tmp_path, monkeypatch):
    robot = StuckRobot()
    async with running(tmp_path, robot, monkeypatch) as module:
        await module.ask(POST)
        await robot.stuck.wait()
        canceled = await module.ask(CancelRequest(id="a", reason="too late", item="back"))
        assert isinstance(canceled, DeliveryRequest)
        assert (canceled.state.value, canceled.destination) == ("underway", "r-5303")
        await module.ask(CancelRequest(id="a", item="deliver"))
        done = await reaches(module, "canceled")
    assert done.reason == "too late; the item was delivered to r-5313 all the same"


async def test_a_restarted_agent_goes_on_where_it_was(tmp_path, monkeypatch):
    robot = HangingRobot()
    async with running(tmp_path, robot, monkeypatch) as module:
        await module.ask(POST)
        await robot.driving.wait()
    robot = ScriptedRobot()
    async with running(tmp_path, robot, monkeypatch) as module:
        await reaches(module, "completed")
        assert robot.ids[0].endswith("-1.4")
