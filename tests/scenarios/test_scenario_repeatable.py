"""A scripted day in lockstep comes out the same, to the tick, however busy the machine is."""

from __future__ import annotations

import asyncio
import json
import sys
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager

import pytest

from navigate.maps import Floor, load_plan
from navigate.messages import NavigateToGoal, WhereIsRoom
from navigate.navigator import Navigator
from navigate.service import NavigateService
from rogue.agent import AgentOptions, run_agent
from rogue.messages import CancelRequest, PostRequest, ReadTrace, RequestChanged, RequestState
from rogue.trace import LISTENING
from tca_bus import Module, TaskFailedError
from tca_bus.testing import bus, central, eventually
from xavier_sim.floors import load_floor
from xavier_sim.messages import Ask, Fault, MoveDoor, ReadPlate, Slip, WhereReally
from xavier_sim.office import Habits, RecordFile, SimulatedPeople, SpeechModule
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.world import World

pytestmark = [pytest.mark.slow, pytest.mark.scenario, pytest.mark.bus]

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
async def office(seed, *more, silence=0.0):
    """Robot, navigator, people and what ``more`` runs, one module that plans, one that meddles."""
    async with bus(clock="sim") as options, central(options):
        state = RobotState(World(load_floor(), seed), SimClock(EPOCH), speed=None)
        speech = SpeechModule(options, RecordFile(None))
        people = SimulatedPeople(speech, seed=seed, habits=Habits(silence=silence))
        navigator = NavigateService(Navigator(Floor(load_plan()), seed=seed), options)
        async with (
            running(RobotModule(state, None, options).run(), navigator.run(), speech.run(people)),
            running(*(runner(options) for runner in more)),
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
    async with office(seed, silence=0.3) as (planner, meddler):
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


async def errands(folder, pause):
    """ROGUE at work: a request is taken back while the robot drives for it, another is late."""
    agent = AgentOptions(folder=folder)
    async with (
        office(5, lambda options: run_agent(agent, options)) as (_, user),
        user.subscribe(RequestChanged) as changes,
    ):
        await user.wait_for(PostRequest, timeout=10)
        for seconds, message in (
            (0.0, post("a", "mitchell", "delivermail", "r-5304", "r-5302")),
            (1.0, post("c", "mitchell", "pickupbook", "r-5302", "r-5301")),
            (12.3, CancelRequest(id="a")),
            (13.0, post("b", "jhm", "deliverfax", "r-5329", "r-5301", deadline="+20s")),
        ):
            async with user.clock.at(EPOCH + seconds):
                await asyncio.sleep(pause)
                await user.query(message)
        ended = {}
        while len(ended) < 3:
            request = (await changes.get()).request
            if request.state.is_final:
                ended[request.id] = (request.state, request.finished - EPOCH)
        # What is said at the end is said after all hear of the end.
        await eventually(lambda: listens(user))
        lines = await user.query(ReadTrace())
        # Of what is said at one tick, who speaks first is not fixed.
        return ended, sorted((line.time, line.text) for line in lines)


async def listens(user):
    return (await user.query(ReadTrace()))[-1].text == LISTENING


def post(name, user, item, pickup, deliver, deadline="+1h"):
    """A request that is tried even if its time is too short."""
    return PostRequest(
        id=name, user=user, item=item, pickup=pickup, deliver=deliver,
        deadline=deadline, anyway=True,
    )  # fmt: skip


async def test_errands_that_are_broken_off_are_so_at_the_same_tick(tmp_path):
    first = await errands(tmp_path / "first", 0.0)
    slow = await errands(tmp_path / "slow", 0.05)
    assert first == slow
    ended, _ = first
    assert ended["a"] == (RequestState.CANCELED, pytest.approx(12.3))
    assert ended["b"] == (RequestState.FAILED, pytest.approx(33.0))
    assert ended["c"][0] is RequestState.COMPLETED


@pytest.mark.timeout(900)
async def test_the_command_plays_a_day_twice_and_it_is_the_same():
    words = ("day", "--twice", "--requests", "2", "--users", "2", "--hours", "0.1", "--json")
    child = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "rogue", *words, stdout=PIPE, stderr=PIPE
    )
    out, err = await child.communicate()
    assert child.returncode == 0, err.decode()
    assert json.loads(out)["repeated"] is True
