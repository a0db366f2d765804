from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from rogue_fakes import FakeModule, HangingRobot, ScriptedRobot, failed, make_request, typed

from navigate.messages import NavigateToGoal
from rogue.conversation import Conversation
from rogue.execution import Executor, Patience, StepRunner, as_published
from rogue.memory import Facts, Store
from rogue.messages import DeliveryRequest, RequestChanged, RequestState
from rogue.outcomes import StepOutcome
from rogue.requests import RequestBook, load_directory

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
    executor = Executor(
        module=module,
        store=store,
        book=book,
        directory=directory,
        robot=robot,
        runner=runner,
        patience=Patience(),
        arrival=as_published(),
    )
    book.on_change = executor.requests_changed
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


async def test_a_failed_step_takes_its_requests_with_it_and_names_the_tray(store: Store):
    at = await scene(store, ScriptedRobot(answers=[typed("y"), typed("i")]))
    await at.book.add(make_request(), None)
    await at.book.add(make_request("b", user="jhm", item="deliverfax"), None)
    await at.execute("acquire-item", ["r-5303", *MAIL])
    await at.execute("deliver-item", ["r-5313", *MAIL])
    ended = await at.request("a")
    assert ended.state is RequestState.FAILED
    assert ended.reason == (
        "deliver-item at r-5313, impossible: the person there said so; "
        "Tom Mitchell's mail delivery is still on the tray"
    )
    assert (await at.request("b")).state is RequestState.QUEUED


async def test_a_blocked_door_fails_all_who_need_that_room(store: Store):
    at = await scene(store, ScriptedRobot(drives=[failed("door_blocked")] * 9))
    await at.book.add(make_request(), None)
    await at.book.add(make_request("b", user="jhm", item="deliverfax", pickup="r-5311"), None)
    await at.book.add(make_request("c", user="veloso", deliver="r-5309"), None)
    await at.execute("goto-deliver-loc", ["mitchell", "r-5313"])
    states = [(await at.request(name)).state.value for name in "abc"]
    assert states == ["failed", "failed", "queued"]


async def test_an_operator_that_serves_nobody_moves_nothing(store: Store):
    at = await scene(store)
    outcome = await at.execute("goto-pickup-loc", ["mitchell", "r-5303"])
    assert outcome.kind == "failed"
    assert at.robot.performed == []
    assert await store.open_step() is None


async def test_three_drives_that_end_elsewhere_are_enough(store: Store):
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
    await asyncio.gather(*at.module.tasks)
    assert robot.killed == [robot.running]
    assert (await at.request("a")).state is RequestState.CANCELED
    assert await store.facts() == Facts(None)


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
