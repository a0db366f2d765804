"""What is watched, for how long, and what becomes of the plans."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import pytest
from rogue_fakes import FakeModule, HangingRobot, ScriptedRobot, failed, make_request

from rogue.conversation import Conversation
from rogue.execution import Executor, KnownWorld, Patience, StepRunner, as_published
from rogue.memory import Hold, Store
from rogue.messages import Closing, RequestState
from rogue.monitors import Kind, Monitor, MonitorRegistry, Watcher, needed, office_monitors
from rogue.outcomes import Outcome, Trouble
from rogue.requests import RequestBook, load_directory
from tca_bus._clock import WallClock
from tca_bus.testing import eventually
from xavier_sim.messages import Battery, BatteryState, DoorMoved, DoorState, ItemMoved, WorldDoors

MAIL = ("mitchell", "delivermail")
PATIENCE = Patience()


def names(monitors: object) -> list[str]:
    return [str(monitor) for monitor in monitors]


def test_an_errand_depends_on_both_its_doors_its_item_and_the_battery() -> None:
    found = needed([make_request()], frozenset(), [])
    assert names(found) == [
        "battery",
        "door r-5303",
        "door r-5313",
        "item mitchell delivermail",
    ]
    assert set(found.values()) == {("a",)}


def test_what_is_on_the_tray_no_longer_depends_on_where_it_came_from() -> None:
    assert Monitor(Kind.DOOR, "r-5303") not in needed([make_request()], {MAIL}, [])


def test_what_goes_back_depends_on_where_it_came_from() -> None:
    closing = Closing(state=RequestState.CANCELED, reason="not needed", since=1.0)
    back = make_request(then="back", closing=closing)
    found = needed([back], {MAIL}, [])
    assert Monitor(Kind.DOOR, "r-5303") in found
    assert Monitor(Kind.DOOR, "r-5313") not in found


def test_somebody_absent_is_watched_while_an_errand_waits_for_them() -> None:
    hold = Hold("a", "r-5303", 1600.0, "nobody answered", Trouble.NOBODY)
    assert Monitor(Kind.PERSON, "r-5303") in needed([make_request()], set(), [hold])
    assert Kind.PERSON not in {m.kind for m in needed([make_request()], set(), [])}


def test_a_monitor_names_all_who_depend_on_it_and_nobody_needs_none() -> None:
    both = needed([make_request(), make_request("b", item="pickupcoffee")], set(), [])
    assert both[Monitor(Kind.DOOR, "r-5313")] == ("a", "b")
    assert needed([], {MAIL}, []) == {}


class Idle(Watcher):
    """Counts its beginnings and ends."""

    kind = Kind.DOOR

    def __init__(self) -> None:
        super().__init__()
        self.begun, self.ended = 0, 0
        self.looked: list[str] = []

    async def listen(self) -> None:
        self.begun += 1
        try:
            await asyncio.get_running_loop().create_future()
        finally:
            self.ended += 1

    async def look(self, subjects: frozenset[str]) -> None:
        self.looked += sorted(subjects)

    def has_looked(self, times: int) -> bool:
        return len(self.looked) == times


async def test_a_monitor_is_on_for_as_long_as_something_depends_on_it() -> None:
    wanted: dict[Monitor, tuple[str, ...]] = {}
    watcher = Idle()
    reviews: list[int] = []

    async def review() -> None:
        reviews.append(len(wanted))

    registry = MonitorRegistry([watcher], lambda: wanted, review, WallClock)
    running = asyncio.create_task(registry.run())
    await eventually(lambda: registry.on() == {} and watcher.begun == 0)
    for number, room in enumerate(("r-5303", "r-5313"), 1):
        wanted[Monitor(Kind.DOOR, room)] = ("a",)
        registry.update()
        await eventually(partial(watcher.has_looked, number))
    assert (watcher.begun, watcher.ended) == (1, 0)
    await eventually(lambda: reviews[-1] == 2)
    assert registry.on() == wanted
    wanted.clear()
    registry.update()
    await eventually(lambda: watcher.ended == 1)
    assert registry.on() == {}
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


class Scene:
    """An agent's parts with all monitors on, and a module by which the world is heard."""

    def __init__(self, store: Store, robot: ScriptedRobot) -> None:
        directory = load_directory()
        self.store, self.robot, self.module = store, robot, FakeModule()
        self.book = RequestBook(self.module, store, directory)
        self.world = KnownWorld(store, self.module)
        said = Conversation(self.module, store)
        self.executor = Executor(
            module=self.module,
            store=store,
            book=self.book,
            world=self.world,
            directory=directory,
            runner=StepRunner(robot, store, "cafe", said.tell_step),
            patience=PATIENCE,
            arrival=as_published(),
        )
        self.monitors = office_monitors(self.module, self.book, self.executor, said, PATIENCE)

        def changed() -> None:
            self.executor.reconsider()
            self.monitors.update()

        self.book.on_change = self.world.on_change = changed

    async def hears(self, *kinds: type) -> None:
        await eventually(lambda: all(kind in self.module.listeners for kind in kinds))

    async def lines(self) -> str:
        return "\n".join(line.text for line in await self.store.lines(0, 1000))


@asynccontextmanager
async def scene(
    folder: Path, *, robot: ScriptedRobot | None = None, closed: tuple[str, ...] = ()
) -> AsyncIterator[Scene]:
    async with Store(folder) as store:
        at = Scene(store, robot or ScriptedRobot())
        at.module.answers[WorldDoors] = [DoorState(room=room, open=False) for room in closed]
        await at.book.add(make_request(), None)
        running = asyncio.create_task(at.monitors.run())
        await at.hears(DoorMoved, ItemMoved, Battery)
        yield at
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


def moved(action: str, room: str = "") -> ItemMoved:
    user, item = MAIL
    return ItemMoved.model_validate(
        {"user": user, "item": item, "room": room, "action": action, "time": 1000.0}
    )


async def test_a_drive_to_a_door_that_is_closed_is_broken_off_and_taken_up_at_once(tmp_path):
    robot = HangingRobot()
    async with scene(tmp_path, robot=robot) as at:
        drive = asyncio.create_task(
            at.executor.execute("goto-pickup-loc", ["mitchell", "r-5303"], ["a"])
        )
        await robot.driving.wait()
        at.module.hear(DoorMoved(room="r-5303", open=False, time=1000.0))
        assert (await drive).trouble is Trouble.UNWANTED
        assert robot.killed == [robot.running]
        assert at.world.is_held("a")
        assert "a is put off: the door of r-5303 is closed" in await at.lines()
        at.module.hear(DoorMoved(room="r-5303", open=True, time=1001.0))
        await eventually(lambda: not at.world.is_held("a"))
        assert "The door of r-5303 is open again: a goes on." in await at.lines()


async def test_a_robot_that_is_shut_in_serves_its_room_only_until_the_door_opens(tmp_path):
    shut = failed("door_blocked", door="r-5303")
    async with scene(tmp_path, robot=ScriptedRobot(drives=[Outcome(), shut])) as at:
        await at.executor.execute("goto-pickup-loc", ["mitchell", "r-5303"], ["a"])
        await at.executor.execute("acquire-item", ["r-5303", *MAIL], ["a"])
        await at.book.add(make_request("b", user="jhm", pickup="r-5311"), None)
        await at.book.add(make_request("c", item="pickupcoffee"), None)
        await at.executor.execute("goto-deliver-loc", ["mitchell", "r-5313"], ["a"])
        assert at.world.facts.room == "r-5303"
        waiting = {r.id for r in at.book.open_requests() if at.world.waits(r)}
        assert waiting == {"a", "b"}
        at.module.hear(DoorMoved(room="r-5303", open=True, time=1001.0))
        await eventually(lambda: not at.world.holds())


async def test_the_door_of_a_room_that_comes_later_puts_nothing_off(tmp_path):
    async with scene(tmp_path, closed=("r-5313",)) as at:
        at.module.hear(DoorMoved(room="r-5313", open=False, time=1000.0))
        at.module.hear(DoorMoved(room="r-5303", open=False, time=1000.0))
        await eventually(lambda: at.world.is_held("a"))
        assert [hold.room for hold in at.world.holds()] == ["r-5303"]


async def test_a_door_that_is_closed_already_is_not_driven_to(tmp_path):
    async with scene(tmp_path, closed=("r-5303",)) as at:
        await eventually(lambda: at.world.is_held("a"))


async def test_a_closed_door_counts_from_when_it_is_the_next_one(tmp_path):
    async with scene(tmp_path, closed=("r-5313",)) as at:
        await at.executor.execute("acquire-item", ["r-5303", *MAIL], ["a"])
        assert [(hold.request, hold.room) for hold in at.world.holds()] == [("a", "r-5313")]


async def test_a_closed_door_is_waited_for_once_and_then_tried(tmp_path):
    async with scene(tmp_path, closed=("r-5303",)) as at:
        await eventually(lambda: at.world.is_held("a"))
        await at.module.clock.advance(PATIENCE.later + 1.0)
        await at.book.add(make_request("b", item="pickupcoffee"), None)
        await eventually(lambda: at.world.is_held("b"))
        assert not at.world.is_held("a")
        at.module.hear(DoorMoved(room="r-5303", open=True, time=1700.0))
        at.module.hear(DoorMoved(room="r-5303", open=False, time=1701.0))
        await eventually(lambda: at.world.is_held("a"))


async def test_the_door_of_the_room_where_the_robot_is_is_no_hindrance(tmp_path):
    async with scene(tmp_path) as at:
        await at.executor.execute("goto-pickup-loc", ["mitchell", "r-5303"], ["a"])
        at.module.hear(DoorMoved(room="r-5303", open=False, time=1000.0))
        await eventually(at.module.listeners[DoorMoved].is_drained)
        assert at.world.holds() == []


async def test_what_is_taken_in_passing_is_known_to_be_gone(tmp_path):
    async with scene(tmp_path) as at:
        at.module.hear(moved("placed", "r-5303"))
        await eventually(lambda: MAIL in at.world.facts.tray)
        at.module.hear(moved("taken"))
        await eventually(lambda: MAIL not in at.world.facts.tray)
        assert (await at.store.facts()).tray == frozenset()
        assert at.book.find("a") is not None


async def test_what_somebody_else_brought_is_done(tmp_path):
    async with scene(tmp_path) as at:
        at.module.hear(moved("brought", "r-5313"))
        await eventually(lambda: at.book.find("a") is None)
        done = await at.store.request("a")
        assert (done.state, done.reason) == (RequestState.COMPLETED, "somebody else brought it")
        await eventually(lambda: at.monitors.on() == {})


async def test_what_was_to_go_back_and_is_taken_has_ended(tmp_path):
    async with scene(tmp_path) as at:
        await at.executor.execute("acquire-item", ["r-5303", *MAIL], ["a"])
        await at.book.give_up("a", RequestState.CANCELED, "not needed")
        at.module.hear(moved("taken"))
        await eventually(lambda: at.book.find("a") is None)
        ended = await at.store.request("a")
        assert ended.state is RequestState.CANCELED
        assert ended.reason == "not needed; somebody took the item from the tray"


async def test_an_answer_to_any_question_at_a_room_tells_that_somebody_is_in(tmp_path):
    robot = ScriptedRobot(answers=[failed("no_answer")] * PATIENCE.asks)
    async with scene(tmp_path, robot=robot) as at:
        await at.executor.execute("acquire-item", ["r-5303", *MAIL], ["a"])
        assert at.world.is_held("a")
        await at.hears(at.module.statuses)
        at.module.answered("r-5313")
        at.module.answered("r-5303")
        await eventually(lambda: not at.world.is_held("a"))


@pytest.mark.parametrize(("low", "times"), [(True, 1), (False, 0)])
async def test_a_low_battery_is_told_once(tmp_path, low, times):
    state = BatteryState(charge=0.12, low=low, charging=False, charger=None, time=1000.0)
    async with scene(tmp_path) as at:
        for _ in range(3):
            at.module.hear(Battery(state=state))
        await eventually(at.module.listeners[Battery].is_drained)
        assert (await at.lines()).count("The battery is low (12%).") == times
