"""What the navigator tells of its belief and of a drive, and what others tell it of its place."""

from __future__ import annotations

import asyncio
import logging
from itertools import pairwise
from types import SimpleNamespace

import pytest
from navigate_loop import Loop
from navigate_office import office, running

from navigate.body import Condition
from navigate.maps import Floor, load_plan
from navigate.messages import (
    MOST_CELLS,
    Belief,
    Believed,
    Look,
    NavigateToGoal,
    NoticeLandmark,
    Position,
    Progress,
    WhereAmI,
    WhereIsRoom,
)
from navigate.navigator import Navigator
from navigate.reporting import belief_state, drive_progress, outlook
from navigate.service import NavigateService, _position_desk, _sparing
from navigate.service._telling import Teller
from navigate.service._whereabouts_log import WhereaboutsLog
from tca_bus import HandlerFailedError, Module, TaskFailedError
from tca_bus.testing import bus
from xavier_sim.messages import CameraPower, Fault, ReadPlate


def test_progress_counts_down_along_the_route():
    loop, told = Loop(seed=3), []
    drive = loop.drive(
        "r-5303",
        each=lambda: told.append(drive_progress(loop.navigator, loop.navigator.driver.drive, "t")),
    )
    assert drive.failure is None
    left = [one.metres_left for one in told if one.metres_left is not None]
    assert 10.0 < left[0] < 15.0
    assert left[-1] < 0.5
    assert max(after - before for before, after in pairwise(left)) < 1.0
    seconds = [one.seconds_left for one in told if one.seconds_left is not None]
    assert seconds[0] > seconds[len(seconds) // 2] > seconds[-1]
    assert told[0].room == "r-5303"
    assert told[-1].goal_mass > 0.9 > told[0].goal_mass
    report = loop.navigator.report(drive)
    assert (report.outcome, report.recoveries) == ("arrived", 0)
    assert report.goal_mass > 0.9
    assert report.entropy < 2.0


def test_a_wide_belief_is_told_by_its_best_cells():
    navigator = Loop().navigator
    narrow = belief_state(navigator, None)
    navigator.localizer.widen(spread=15.0, turn_spread=2.0)
    wide = belief_state(navigator, navigator.floor.place("r-5303"))
    masses = [cell.mass for cell in wide.cells]
    assert sum(cell.mass for cell in narrow.cells[:4]) > 0.95
    assert len(wide.cells) == MOST_CELLS
    assert masses == sorted(masses, reverse=True)
    assert wide.entropy > 6.0
    assert narrow.entropy < 2.0
    assert wide.lost
    assert wide.position.lost
    assert not narrow.position.lost
    assert narrow.goal_mass is None
    assert 0.0 <= wide.goal_mass < 0.2


@pytest.mark.parametrize(("sure", "moves"), [(0.95, 1), (0.5, 0), (0.05, -1)])
def test_a_landmark_moves_belief_by_the_odds_of_its_sight(sure, moves):
    navigator = Loop().navigator
    navigator.set_position("r-5303")
    navigator.localizer.widen(spread=2.0, turn_spread=0.1)
    before = navigator.mass_seeing("r-5303")
    navigator.notice("R-5303", sure=sure)
    after = navigator.mass_seeing("r-5303")
    odds = before / (1.0 - before) * sure / (1.0 - sure)
    assert after == pytest.approx(odds / (1.0 + odds), abs=0.01)
    assert (after > before) - (after < before) == moves


def test_a_landmark_out_of_sight_overrules_nothing():
    navigator = Loop().navigator
    before = navigator.position()
    navigator.notice("r-5313", sure=0.99)
    assert navigator.position() == before


@pytest.mark.bus
async def test_belief_and_progress_are_told_once_a_second_of_a_drive():
    async with (
        office() as asker,
        asker.subscribe(Belief) as beliefs,
        asker.subscribe(Progress) as told,
    ):
        room = await asker.query(WhereIsRoom(room="r-5302"))
        handle = await asker.expand(NavigateToGoal(x=room.x, y=room.y))
        report = await handle.result(timeout=40)
        drives, states = [], []
        async with asyncio.timeout(10):
            while not drives or drives[-1].time < report.position.time:
                drives.append((await anext(told)).drive)
            while not states or states[-1].position.time < report.position.time:
                states.append((await anext(beliefs)).state)
    assert {drive.task for drive in drives} == {handle.id}
    assert (drives[0].x, drives[0].y, drives[0].room) == (room.x, room.y, "r-5302")
    gaps = [two.time - one.time for one, two in pairwise(drives)]
    assert all(0.99 <= gap < 1.11 for gap in gaps[:-1])
    assert drives[-1].goal_mass == states[-1].goal_mass == report.goal_mass > 0.9
    assert states[-1].position.room == "r-5302"


@pytest.mark.bus
async def test_it_looks_and_is_told_what_is_seen():
    async with office() as asker:
        await asker.query(Fault(fault=CameraPower(on=False)))
        with pytest.raises(HandlerFailedError, match="camera") as gone:
            await asker.query(Look())
        assert gone.value.failure.name == "camera_gone"
        await asker.query(Fault(fault=CameraPower(on=True)))
        sight = await asker.query(Look())
        assert 0.0 <= sight.expected <= 1.0
        assert sight.position.x == (await asker.query(WhereAmI())).x
        noticed = await asker.execute(NoticeLandmark(room="r-5303", confidence=0.9))
        assert (await noticed.result(timeout=10)).room == sight.position.room
        unknown = await asker.execute(NoticeLandmark(room="lounge"))
        with pytest.raises(TaskFailedError) as caught:
            await unknown.result(timeout=10)
        assert caught.value.failure.name == "unknown_room"
        state = await asker.query(Believed())
        assert sum(cell.mass for cell in state.cells) == pytest.approx(1.0, abs=0.01)


@pytest.mark.bus
async def test_a_camera_that_hangs_or_dies_while_it_looks_is_gone(monkeypatch):
    monkeypatch.setattr(_position_desk, "LOOK_SECONDS", 0.3)
    begun = asyncio.Event()

    async def hang(_query, _context):
        begun.set()
        await asyncio.Event().wait()

    async with bus() as options, Module("asker", options=options) as asker:
        service = NavigateService(Navigator(Floor(load_plan())), options)
        async with running(service.run()):
            await asker.wait_for(Look, timeout=10)
            with pytest.raises(HandlerFailedError) as without:
                await asker.query(Look())
            camera = Module("camera", options=options)
            camera.serve(ReadPlate, hang)
            async with camera:
                await service.module.wait_for(ReadPlate, timeout=10)
                with pytest.raises(HandlerFailedError, match=r"no answer within 0\.3 s") as hangs:
                    await asker.query(Look())
                monkeypatch.setattr(_position_desk, "LOOK_SECONDS", 60.0)
                begun.clear()
                last = asyncio.ensure_future(asker.query(Look()))
                await begun.wait()
            with pytest.raises(HandlerFailedError, match="was lost") as dies:
                await last
    names = [caught.value.failure.name for caught in (without, hangs, dies)]
    assert names == ["no_camera", "camera_gone", "camera_gone"]


class Silence:
    """A module to which nobody listens."""

    async def broadcast(self, _message: object) -> None:
        """Say it to nobody."""


def test_what_is_wrong_with_a_sense_is_told_and_said_once(caplog):
    navigator = Loop().navigator
    teller = Teller(navigator, Silence())
    sonars = navigator.perception.sonars
    sonars.unsound[3], sonars.conditions[3] = True, Condition.STUCK
    asyncio.run(teller.stepped())
    asyncio.run(teller.stepped())
    assert outlook(navigator, None, None, "").faults == {"sonar 3": "stuck"}
    sonars.unsound[3] = False
    asyncio.run(teller.stepped())
    assert [record.getMessage() for record in caplog.records] == [
        "sonar 3 is stuck and is left out until it behaves",
        "sonar 3 behaves again",
    ]
    assert outlook(navigator, None, None, "").faults == {}


@pytest.fixture
def wall(monkeypatch):
    """A wall clock that the test moves."""
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr(_sparing, "time", SimpleNamespace(monotonic=lambda: clock.now))
    return clock


def test_a_robot_that_is_lost_says_so_where_it_is_asked_and_in_the_progress_of_its_drive():
    loop = Loop()
    drive = loop.start("r-5303")
    assert not loop.navigator.position().lost
    assert not drive_progress(loop.navigator, drive, "t").lost
    loop.navigator.localizer.widen(spread=15.0, turn_spread=2.0)
    assert loop.navigator.position().lost
    assert drive_progress(loop.navigator, drive, "t").lost


def test_positions_and_progress_of_those_who_say_nothing_of_being_lost_are_understood():
    loop = Loop()
    old = loop.navigator.position().model_dump(exclude={"lost", "heard"})
    assert Position.model_validate(old) == loop.navigator.position()
    told = drive_progress(loop.navigator, loop.start("r-5303"), "t")
    assert type(told).model_validate(told.model_dump(exclude={"lost"})) == told


def test_a_robot_has_been_heard_once_it_sensed_and_is_still_after_a_thaw_but_not_after_a_restart():
    loop, floor = Loop(), Floor(load_plan())
    assert loop.navigator.position().heard
    thawed, restarted = Navigator(floor), Navigator(floor)
    assert not thawed.position().heard
    thawed.thaw(loop.navigator.freeze())
    restarted.restore(loop.navigator.snapshot())
    assert thawed.position().heard
    assert not restarted.position().heard


def test_a_robot_that_gets_lost_and_finds_itself_is_in_the_log_once_a_minute_at_most(wall, caplog):
    caplog.set_level(logging.INFO)
    localizer = SimpleNamespace(lost=False)
    here = Loop().navigator.position()
    navigator = SimpleNamespace(
        localizer=localizer,
        position=lambda: here.model_copy(update={"lost": localizer.lost}),
    )
    words = WhereaboutsLog()
    for tick in range(900):
        localizer.lost = 10 <= tick < 500 and tick % 2 == 0
        words.stepped(navigator)
        wall.now += 0.1
    lines = [(record.levelname, record.getMessage()[:35]) for record in caplog.records]
    lost = ("WARNING", "the robot is lost: it may be at (7.")
    found = ("INFO", "the robot has found itself at (7.57")
    assert lines == [lost, found]
    localizer.lost = True
    words.stepped(navigator)
    assert len(caplog.records) == 3
    localizer.lost = False
    words.stepped(navigator)
    assert len(caplog.records) == 4


def test_what_could_not_be_said_in_the_log_is_said_later_if_it_still_holds(wall, caplog):
    navigator = Loop().navigator
    words = WhereaboutsLog()
    for spread in (15.0, 0.01, 15.0):
        navigator.localizer.place(navigator.pose, spread=0.01, turn_spread=0.01)
        navigator.localizer.widen(spread=spread, turn_spread=0.01)
        words.stepped(navigator)
    assert len(caplog.records) == 1
    wall.now += 60.0
    words.stepped(navigator)
    assert len(caplog.records) == 2
