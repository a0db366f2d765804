from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from rogue_fakes import FakeModule, HangingRobot, ScriptedRobot, failed, make_request, typed

from navigate.messages import NavigateToGoal
from rogue.conversation import Conversation
from rogue.execution import Executor, KnownWorld, Patience, StepRunner, as_published
from rogue.explain import DecisionKind
from rogue.memory import Facts, Store
from rogue.messages import DeliveryRequest, RequestChanged, RequestState
from rogue.outcomes import StepOutcome, Trouble
from rogue.requests import RequestBook, load_directory
from xavier_sim.messages import BatteryState, Corner

MAIL = ("mitchell", "delivermail")


@dataclass
class Scene:
    store: Store
    module: FakeModule
    book: RequestBook
    executor: Executor
    robot: ScriptedRobot

    async def execute(self, operator: str, arguments: list[str]) -> StepOutcome:
        ids = [request.id for request in self.book.open_requests()]
        return await self.executor.execute(operator, arguments, ids)

    async def request(self, name: str) -> DeliveryRequest:
        found = await self.store.request(name)
        assert found is not None
        return found


async def scene(store: Store, robot: ScriptedRobot | None = None) -> Scene:
    module, robot = FakeModule(), robot or ScriptedRobot()
    directory = load_directory()
    book = RequestBook(module, store, directory)
    runner = StepRunner(robot, store, "cafe", Conversation(module, store).tell_step)
    world = KnownWorld(store, module)
    await world.load()
    executor = Executor(
        module=module,
        store=store,
        book=book,
        world=world,
        directory=directory,
        runner=runner,
        patience=Patience(),
        arrival=as_published(),
    )
    book.on_change = world.on_change = executor.reconsider
    await book.load()
    return Scene(store, module, book, executor, robot)


@pytest.fixture
async def store(tmp_path: Path) -> AsyncIterator[Store]:
    async with Store(tmp_path) as store:
        yield store


async def test_a_whole_errand_leaves_the_right_facts(store: Store):
    at = await scene(store)
    await at.book.add(make_request(), None)
    await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    assert await store.facts() == Facts("r-5303")
    assert (await at.request("a")).state is RequestState.UNDERWAY
    await at.execute("acquire-item", ["r-5303", *MAIL])
    assert await store.facts() == Facts("r-5303", frozenset({MAIL}))
    await at.execute("goto-deliver-loc", ["mitchell", "r-5313"])
    await at.execute("deliver-item", ["r-5313", *MAIL])
    assert await store.facts() == Facts("r-5313")
    done = await at.request("a")
    assert (done.state, done.finished, done.reason) == (RequestState.COMPLETED, 1000.0, None)
    assert at.book.open_requests() == []
    states = [m.request.state.value for m in at.module.said if isinstance(m, RequestChanged)]
    assert states == ["queued", "underway", "completed"]


async def test_what_cannot_be_delivered_goes_back_before_it_has_failed(store: Store):
    at = await scene(store, ScriptedRobot(answers=[typed("y"), typed("i")]))
    await at.book.add(make_request(), None)
    await at.book.add(make_request("b", user="jhm", item="deliverfax"), None)
    await at.execute("acquire-item", ["r-5303", *MAIL])
    await at.execute("deliver-item", ["r-5313", *MAIL])
    closing = await at.request("a")
    assert (closing.state, closing.destination) == (RequestState.UNDERWAY, "r-5303")
    await at.execute("deliver-item", ["r-5303", *MAIL])
    ended = await at.request("a")
    assert ended.state is RequestState.FAILED
    assert ended.reason == (
        "deliver-item at r-5313, impossible: the person there said so; the item is back in r-5303"
    )
    assert (await at.request("b")).state is RequestState.QUEUED


async def test_what_cannot_even_go_back_is_said_to_be_on_the_tray(store: Store):
    at = await scene(store, ScriptedRobot(answers=[typed("y"), typed("i"), typed("i")]))
    await at.book.add(make_request(), None)
    await at.execute("acquire-item", ["r-5303", *MAIL])
    await at.execute("deliver-item", ["r-5313", *MAIL])
    await at.execute("deliver-item", ["r-5303", *MAIL])
    ended = await at.request("a")
    assert ended.state is RequestState.FAILED
    assert ended.reason is not None
    assert ended.reason.endswith("; Tom Mitchell's mail delivery is still on the tray")


async def test_a_blocked_door_puts_off_all_who_need_that_room_next(store: Store):
    at = await scene(store, ScriptedRobot(drives=[failed("door_blocked")]))
    await at.book.add(make_request(), None)
    await at.book.add(make_request("b", user="jhm", item="deliverfax", pickup="r-5303"), None)
    await at.book.add(make_request("c", user="veloso", pickup="r-5309"), None)
    await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    assert [at.executor.world.is_held(name) for name in "abc"] == [True, True, False]
    assert (await at.request("a")).state is RequestState.SUSPENDED
    assert at.executor.world.next_due(at.book.open_requests()) == 1000.0 + Patience().later
    decided = await store.decisions("a")
    assert [(one.kind, one.until, one.reason) for one in decided] == [
        (
            DecisionKind.POSTPONED,
            1600.0,
            "cannot get to r-5303, door_blocked: it was door_blocked",
        )
    ]


async def test_what_is_to_go_back_does_not_wait_for_the_room_where_it_was_to_go(store: Store):
    at = await scene(store, ScriptedRobot(drives=[failed("door_blocked")]))
    await at.book.add(make_request(), None)
    await at.execute("acquire-item", ["r-5303", *MAIL])
    await at.execute("goto-deliver-loc", ["mitchell", "r-5313"])
    assert at.executor.world.waits(await at.request("a"))
    await at.book.give_up("a", RequestState.CANCELED, "not needed")
    assert at.executor.world.waits(await at.request("a")) is None


async def test_what_is_put_off_is_still_so_after_a_restart(tmp_path: Path):
    async with Store(tmp_path) as store:
        at = await scene(store, ScriptedRobot(drives=[failed("door_blocked")]))
        await at.book.add(make_request(), None)
        await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    async with Store(tmp_path) as store:
        at = await scene(store)
        assert at.executor.world.is_held("a")
        await at.module.clock.advance(Patience().later)
        assert not at.executor.world.is_held("a")


async def test_what_is_put_off_is_taken_up_when_its_room_is_open(store: Store):
    at = await scene(store, ScriptedRobot(drives=[failed("door_blocked")]))
    await at.book.add(make_request(), None)
    await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    await at.executor.world.take_up("r-5305", {Trouble.BLOCKED})
    assert at.executor.world.is_held("a")
    await at.executor.world.take_up("r-5303", {Trouble.NOBODY})
    assert at.executor.world.is_held("a")
    assert await at.executor.world.take_up("r-5303", {Trouble.BLOCKED}) == ["a"]
    assert not at.executor.world.is_held("a")
    assert await store.holds() == []


async def test_an_operator_that_serves_nobody_moves_nothing(store: Store):
    at = await scene(store)
    outcome = await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    assert outcome.kind == "failed"
    assert at.robot.performed == []
    assert await store.open_step() is None


LOW = BatteryState(charge=0.15, low=True, charging=False, charger=Corner(x=7.5, y=12.0), time=0.0)


async def test_a_low_battery_is_charged_before_the_robot_drives_on(store: Store):
    at = await scene(store)
    at.executor.world.battery = LOW
    await at.book.add(make_request(), None)
    await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    first, second = (m for m in at.robot.performed if isinstance(m, NavigateToGoal))
    assert (first.x, first.y) == (750.0, 1200.0)
    assert (second.x, second.y) == (567.0, 2316.5)
    assert at.robot.charged == [Patience().charge]
    assert at.robot.urgencies[0].priority > at.robot.urgencies[1].priority
    assert await store.facts() == Facts("r-5303")
    await at.execute("goto-deliver-loc", ["mitchell", "r-5313"])
    assert at.robot.charged == [Patience().charge]


async def test_nothing_is_charged_while_somebody_hands_something_over(store: Store):
    at = await scene(store)
    at.executor.world.battery = LOW
    await at.book.add(make_request(), None)
    await at.execute("acquire-item", ["r-5303", *MAIL])
    assert at.robot.count(NavigateToGoal) == 0


async def test_a_charger_out_of_reach_stops_no_errand(store: Store):
    at = await scene(store, ScriptedRobot(drives=[failed("corridor_blocked")]))
    at.executor.world.battery = LOW
    await at.book.add(make_request(), None)
    outcome = await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    assert outcome.kind == "done"
    assert at.robot.charged == []
    again = await scene(store)
    again.executor.world.battery = LOW
    await again.book.load()
    await again.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    assert again.robot.charged == []
    again.module.clock.move_to(1000.0 + Patience().later)
    await again.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    assert again.robot.charged == [Patience().charge]


async def test_three_arrivals_elsewhere_are_enough(store: Store):
    at = await scene(store, ScriptedRobot(answers=[typed("n"), typed("r-5305")] * 9))
    await at.book.add(make_request(), None)
    for kind in ("elsewhere", "elsewhere", "elsewhere"):
        assert (await at.request("a")).state is not RequestState.FAILED
        outcome = await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
        assert outcome.kind == kind
    assert (await at.request("a")).state is RequestState.FAILED
    assert at.robot.count(NavigateToGoal) == 9


async def test_a_drive_that_nobody_wants_any_more_is_broken_off(store: Store):
    robot = HangingRobot()
    at = await scene(store, robot)
    await at.book.add(make_request(), None)
    drive = asyncio.create_task(at.execute("goto-pickup-loc", ["mitchell", "r-5303"]))
    await robot.driving.wait()
    request = at.book.find("a")
    assert request is not None
    await at.book.end(request, RequestState.CANCELED, "not needed")
    assert (await drive).kind == "failed"
    assert robot.killed == [robot.running]
    assert (await at.request("a")).state is RequestState.CANCELED
    assert await store.facts() == Facts(None)


async def test_a_drive_with_an_item_that_was_taken_on_the_way_is_broken_off(store: Store):
    at = await scene(store)
    await at.book.add(make_request(), None)
    await at.execute("acquire-item", ["r-5303", *MAIL])
    robot = HangingRobot()
    at = await scene(store, robot)
    drive = asyncio.create_task(at.execute("goto-deliver-loc", ["mitchell", "r-5313"]))
    await robot.driving.wait()
    await at.executor.world.move_things(gone=[MAIL])
    assert (await drive).trouble is Trouble.UNWANTED
    assert robot.killed == [robot.running]
    assert (await at.request("a")).state is RequestState.UNDERWAY
    assert await store.facts() == Facts(None)


async def test_a_drive_that_nobody_wants_after_a_restart_is_killed_in_the_tree(tmp_path: Path):
    async with Store(tmp_path) as store:
        robot = HangingRobot()
        at = await scene(store, robot)
        await at.book.add(make_request(), None)
        drive = asyncio.create_task(at.execute("goto-pickup-loc", ["mitchell", "r-5303"]))
        await robot.driving.wait()
        drive.cancel()
        await asyncio.gather(drive, return_exceptions=True)
    async with Store(tmp_path) as store:
        at = await scene(store)
        await at.book.end(make_request(), RequestState.CANCELED, "not needed")
        await at.executor.resume()
        assert at.robot.killed == [robot.running]
        assert at.robot.performed == []
        assert await store.open_step() is None


async def test_a_step_that_was_open_at_the_end_is_ended_at_the_beginning(tmp_path: Path):
    async with Store(tmp_path) as store:
        at = await scene(store, HangingRobot())
        await at.book.add(make_request(), None)
        step = asyncio.create_task(at.execute("acquire-item", ["r-5303", *MAIL]))
        await at.robot.driving.wait()
        step.cancel()
        await asyncio.gather(step, return_exceptions=True)
        assert await store.open_step() is not None
    async with Store(tmp_path) as store:
        at = await scene(store)
        await at.executor.resume()
        assert await store.open_step() is None
        assert (await store.facts()).tray == {MAIL}
        assert len(at.robot.ids) == 3


async def test_a_canceled_drive_is_not_taken_up_again(tmp_path: Path):
    async with Store(tmp_path) as store:
        at = await scene(store)
        await at.book.add(make_request(), None)
        await store.begin_step("goto-pickup-loc", ("mitchell", "r-5303"), [make_request()], 0.0)
        await at.book.end(make_request(), RequestState.CANCELED, "not needed")
        await at.executor.resume()
        assert at.robot.performed == []
        assert await store.open_step() is None
