"""A scripted day in lockstep comes out the same, to the tick, however busy the machine is."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest

from navigate.floor import Floor
from navigate.floorfile import load_plan
from navigate.messages import NavigateToGoal, WhereIsRoom
from navigate.navigator import Navigator
from navigate.service import NavigateService
from tca_bus import Module, TaskFailedError
from tca_bus.testing import bus, central
from xavier_sim.floor import load_floor
from xavier_sim.messages import Ask, Fault, MoveDoor, ReadPlate, Slip, WhereReally
from xavier_sim.people import Habits
from xavier_sim.robot_module import RobotModule
from xavier_sim.robot_state import RobotState
from xavier_sim.simulated_time import SimClock
from xavier_sim.speech_module import SimulatedPeople, SpeechModule
from xavier_sim.spoken_record import RecordFile
from xavier_sim.world import World

pytestmark = [pytest.mark.scenario, pytest.mark.bus]

EPOCH = 826_000_000.0


@asynccontextmanager
async def running(*runners):
    async with asyncio.TaskGroup() as group:
        tasks = [group.create_task(runner) for runner in runners]
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()


@asynccontextmanager
async def office(seed):
    """Robot, navigator and people on a bus, and one module that plans, one that interferes."""
    async with bus(clock="sim") as options, central(options):
        state = RobotState(World(load_floor(), seed), SimClock(EPOCH), speed=None)
        speech = SpeechModule(options, RecordFile(None))
        people = SimulatedPeople(speech, seed=seed, habits=Habits(silence=0.3))
        navigator = NavigateService(Navigator(Floor(load_plan()), seed=seed), options)
        async with (
            running(RobotModule(state, None, options).run(), navigator.run(), speech.run(people)),
            Module("planner", options=options) as planner,
            Module("meddler", options=options) as meddler,
        ):
            await planner.wait_for(NavigateToGoal, Ask, WhereReally, timeout=10)
            await asyncio.gather(planner.clock.wait_ready(10), meddler.clock.wait_ready(10))
            yield planner, meddler


class Diary:
    """What happened at which tick."""

    def __init__(self, module):
        self.module, self.lines = module, []

    async def note(self, what):
        truth = await self.module.query(WhereReally())
        self.lines.append((truth.tick, what, truth.x, truth.y, self.module.clock.now()))


async def plan(module, diary, rooms, pause):
    """Drive to some rooms and ask there, thinking for ``pause`` wall seconds in between."""
    for room in rooms:
        place = await module.query(WhereIsRoom(room=room))
        await asyncio.sleep(pause)
        goal = await module.expand(NavigateToGoal(x=place.x, y=place.y))
        await diary.note(await outcome(goal))
        await asyncio.sleep(pause)
        ask = Ask(question=f"Am I at {room}?", choices=("y", "n"), about="place", room=room)
        await diary.note(await outcome(await module.execute(ask)))
        await diary.note((await module.query(ReadPlate())).text)


async def outcome(handle):
    try:
        result = await handle.result(timeout=60)
    except TaskFailedError as error:
        return error.failure.name
    return getattr(result, "answer", "arrived")


async def meddle(module, diary, pause):
    """Post something, shut a door and make a fault, each at its very time."""
    for seconds, message in (
        (5.0, MoveDoor(room="r-5301", open=False)),
        (21.3, Fault(fault=Slip(metres=0.2))),
        (64.95, MoveDoor(room="r-5301", open=True)),
        (90.0, MoveDoor(room="r-5304", open=True)),
    ):
        async with module.clock.at(EPOCH + seconds):
            await asyncio.sleep(pause)
            await module.query(message)
            await diary.note(message.wire_name)


async def day(seed, pause, rooms=("r-5302", "r-5301", "r-5304")):
    async with office(seed) as (planner, meddler):
        diaries = Diary(planner), Diary(meddler)
        meddling = asyncio.create_task(meddle(meddler, diaries[1], pause), name="meddle")
        await plan(planner, diaries[0], rooms, pause)
        meddling.cancel()
        await asyncio.gather(meddling, return_exceptions=True)
        return diaries[0].lines, diaries[1].lines


async def test_the_same_day_again_is_the_same_to_the_tick():
    first, slow = await day(3, 0.0), await day(3, 0.05)
    assert first == slow
    plans, meddlings = first
    assert len(plans) == 9
    assert [tick for tick, *_ in meddlings[:3]] == [50, 213, 650]
    other, _ = await day(4, 0.0, ("r-5302",))
    assert other != plans[:3]
