"""The navigate module on a real bus, with the real robot in lockstep."""

from __future__ import annotations

import asyncio
import json
import math
import os
import signal
import sys

import pytest
from command_line import run_command
from navigate_office import office, running
from navigate_readings import reading

from navigate.cli import app
from navigate.keeping import StateFile
from navigate.maps import Floor, load_plan
from navigate.messages import (
    NavigateToGoal,
    NavigationReport,
    PlanRoute,
    PlanRoutes,
    Rooms,
    SetPosition,
    ShowMap,
    StopDriving,
    WhereAmI,
    WhereIsRoom,
)
from navigate.navigator import Navigator
from navigate.service import NavigateService, _keeper
from navigate.service._helm import SENSOR_SECONDS
from navigate.service._map_desk import MapDesk
from tca_bus import HandlerFailedError, KilledError, Module, TaskFailedError
from tca_bus.testing import bus, central, eventually
from xavier_sim.messages import Drive, MoveDoor, Sensors, WhereReally

pytestmark = pytest.mark.bus


async def test_a_goal_on_the_bus_drives_the_robot_there():
    async with office() as asker:
        room = await asker.query(WhereIsRoom(room="r-5302"))
        handle = await asker.expand(NavigateToGoal(x=room.x, y=room.y))
        report = await handle.result(timeout=40)
        truth = await asker.query(WhereReally())
        assert report.position.room == "r-5302" == truth.room
        assert math.dist((truth.x, truth.y), (room.x / 100, room.y / 100)) < 0.25
        assert report.metres == pytest.approx(truth.metres, abs=1.0)
        assert (await asker.query(WhereAmI())).room == "r-5302"


async def test_failures_cross_the_bus_with_their_name_and_report():
    async with office() as asker:
        outside = await asker.expand(NavigateToGoal(x=-9000.0, y=0.0))
        with pytest.raises(TaskFailedError) as caught:
            await outside.result(timeout=20)
        assert caught.value.failure.name == "no_route"
        assert caught.value.failure.data["recoveries"] == 0
        await asker.query(MoveDoor(room="r-5302", open=False))
        room = await asker.query(WhereIsRoom(room="r-5302"))
        blocked = await asker.expand(NavigateToGoal(x=room.x, y=room.y))
        with pytest.raises(TaskFailedError) as caught:
            await blocked.result(timeout=40)
        assert caught.value.failure.name == "door_blocked"
        assert caught.value.failure.data["metres"] > 5


async def test_a_goal_off_the_map_needs_no_robot_to_fail():
    async with bus() as options, central(options):
        service = NavigateService(Navigator(Floor(load_plan())), options)
        asker = Module("asker", options=options)
        async with asker, running(service.run()):
            outside = await asker.expand(NavigateToGoal(x=-9000.0, y=0.0), wait_for_handler=10)
            with pytest.raises(TaskFailedError, match=r"did not get to .*: no route to") as caught:
                await outside.result(timeout=SENSOR_SECONDS / 2)
    assert caught.value.failure.name == "no_route"
    report = NavigationReport.model_validate(caught.value.failure.data)
    assert (report.outcome, report.recoveries, report.position.heard) == ("no_route", 0, False)


async def test_a_killed_goal_stops_the_robot():
    async with office() as asker, asker.subscribe(Sensors) as sensed:
        handle = await asker.expand(NavigateToGoal(x=2187.0, y=7000.0))
        async for sensors in sensed:
            if sensors.speed > 0.4:
                break
        await handle.kill("changed our mind")
        with pytest.raises(KilledError):
            await handle.result(timeout=10)
        before = await asker.query(WhereReally())
        after = await asker.query(WhereReally())
        assert after.tick == before.tick
        again = await asker.expand(NavigateToGoal(x=before.x * 100, y=before.y * 100))
        assert (await again.result(timeout=20)).metres < 1.0


async def test_a_drive_can_be_stopped_past_the_task_tree():
    async with office() as asker, asker.subscribe(Sensors) as sensed:
        handle = await asker.expand(NavigateToGoal(x=2187.0, y=7000.0))
        async for sensors in sensed:
            if sensors.speed > 0.4:
                break
        position = await asker.query(StopDriving())
        with pytest.raises(TaskFailedError, match="stopped by asker") as caught:
            await handle.result(timeout=10)
        failure = caught.value.failure
        assert failure.name == "cancelled" == failure.data["outcome"]
        assert failure.data["metres"] > 0
        assert position.time >= sensors.time
        idle = await asker.query(StopDriving())
        assert idle.room == position.room


SOUND = {
    "period": 0.1,
    "lockstep": True,
    "sonar": [1.0, math.nan, -1.0] + [2.0] * 21,
    "sonar_fresh": 7,
    "odom": [0.0, 0.0, 0.0],
    "speed": 0.0,
    "turn_rate": 0.0,
    "bump": 0,
}


@pytest.mark.parametrize(
    "wrong",
    [
        {"sonar": [1.0] * 23},
        {"sonar": [math.nan] * 24},
        {"striper": [1.0] * 30},
        {"lidar": [1.0]},
        {"odom": [0.0, 0.0]},
        {"odom": [0.0, math.nan, 0.0]},
        {"time": math.inf},
    ],
)
async def test_useless_sensors_stop_the_wheels_and_nothing_else(wrong):
    answers = asyncio.Queue()

    async def take(drive, _context):
        answers.put_nowait(drive)

    async with bus() as options:
        service = NavigateService(Navigator(Floor(load_plan())), options)
        robot = Module("robot", options=options)
        robot.serve(Drive, take)
        async with robot, running(service.run()):
            await robot.wait_for(NavigateToGoal, timeout=10)
            await service.module.wait_for(Drive, timeout=10)
            for tick, fields in enumerate((wrong, {}, wrong, {})):
                await robot.broadcast_json("xavierSensors", {"tick": -1, "time": "noon"})
                sound = {**SOUND, "tick": tick, "time": 1000.0 + tick / 10}
                await robot.broadcast(Sensors.model_validate({**sound, **fields}))
                async with asyncio.timeout(10):
                    drive = await answers.get()
                assert (drive.tick, drive.speed, drive.busy) == (tick, 0.0, False)


async def test_questions_about_rooms_routes_and_places():
    async with office() as asker:
        rooms = await asker.query(Rooms())
        assert len(rooms) == 60
        assert await asker.query(ShowMap()) == load_plan()
        route = await asker.query(PlanRoute(goal="r-5303"))
        assert route.via[-1] == "r-5303"
        table = await asker.query(PlanRoutes(rooms=[room.room for room in rooms]))
        assert table.rooms[1] == "r-5303"
        assert table.from_here[1] == route.metres
        assert all(table.metres[i][i] == 0.0 and len(table.metres[i]) == 60 for i in range(60))
        for question in (
            WhereIsRoom(room="r-53033"),
            PlanRoute(goal="r-53033"),
            PlanRoutes(rooms=["r-5303", "r-53033"]),
        ):
            with pytest.raises(HandlerFailedError, match="'r-5303'") as caught:
                await asker.query(question)
            assert caught.value.failure.name == "unknown_room"
        told = await asker.execute(SetPosition(room="r-5303"))
        position = await told.result(timeout=10)
        assert position.room == "r-5303"
        assert 0.0 <= position.confidence <= 1.0
        told = await asker.execute(SetPosition(room="r-5303", theta=2.0))
        assert (await told.result(timeout=10)).theta == pytest.approx(2.0, abs=1e-3)
        wrong = await asker.execute(SetPosition(room="lounge"))
        with pytest.raises(TaskFailedError) as failed:
            await wrong.result(timeout=10)
        assert failed.value.failure.name == "unknown_room"


async def test_distances_as_built_do_not_depend_on_what_is_in_the_way_now():
    navigator = Navigator(Floor(load_plan()), seed=1)
    navigator.memory.shut("d-5303", navigator.time)
    rooms = ["r-5303", "r-5311"]
    async with bus() as options:
        module = Module("navigate", options=options)
        MapDesk(navigator, module)
        async with module, Module("asker", options=options) as asker:
            await asker.wait_for(PlanRoutes, timeout=10)
            now = await asker.query(PlanRoutes(rooms=rooms))
            built = await asker.query(PlanRoutes(rooms=rooms, as_built=True))
    assert now.metres == [[0.0, None], [None, 0.0]]
    assert built.metres == [[0.0, 18.32], [18.32, 0.0]]


async def test_what_it_knows_is_kept_and_read_again(tmp_path):
    async with office(tmp_path):
        await eventually((tmp_path / "navigate.json").exists)
    state = StateFile(tmp_path).load()
    assert state["map"] == "wean5"
    navigator = Navigator(Floor(load_plan()))
    navigator.restore(state)
    assert navigator.position().time == state["time"]


@pytest.mark.parametrize("text", ["", "[1, 2]", "{", '{"map": "wean5", "pose": [1]}'])
async def test_a_spoilt_state_is_left_aside(tmp_path, text, caplog):
    (tmp_path / "navigate.json").write_text(text)
    async with office(tmp_path) as asker:
        start = load_plan().start
        position = await asker.query(WhereAmI())
        assert math.dist((position.x, position.y), (start.x, start.y)) < 0.2
    assert "cannot be used" in caplog.text


async def test_a_folder_that_cannot_be_written_is_told_once(tmp_path, monkeypatch, caplog):
    tries, kept = [], StateFile(tmp_path)
    monkeypatch.setattr(_keeper, "SAVE_SECONDS", 0.0)

    def save(_state):
        tries.append(len(tries))
        if len(tries) != 4:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(kept, "save", save)
    navigator = Navigator(Floor(load_plan()))

    def sensed():
        navigator.time += 1.0
        return True

    async with running(_keeper.keep(navigator, kept, sensed=sensed)):
        await eventually(lambda: len(tries) > 7)
    said = [line for line in caplog.messages if "cannot be written: No space" in line]
    assert len(said) == 2


@pytest.mark.parametrize(
    "spoilt",
    [
        {"pose": [math.nan, 0.0, 0.0]},
        {"deviation": math.inf},
        {"odom": [0.0, 0.0]},
        {"time": "noon"},
        {"hindrances": {"doors": [], "points": [[1.0]]}},
    ],
)
def test_of_a_state_that_is_spoilt_nothing_is_taken(spoilt):
    navigator = Navigator(Floor(load_plan()))
    before = navigator.snapshot()
    moved = {**before, "pose": [5.7, 23.2, 0.0], "time": 7.0}
    with pytest.raises((KeyError, TypeError, ValueError)):
        navigator.restore(moved | spoilt)
    assert navigator.snapshot() == before


async def navigate(*arguments):
    ran = await run_command(app, *arguments)
    return ran.code, ran.out, ran.err


async def test_the_command_line_plans_and_tells_where():
    async with office() as asker:
        flags = ("--connect", asker.options.connect, "--realm", asker.options.realm)
        code, out, _ = await navigate("plan", "r-5301", "r-5313", "--json", *flags)
        _, where, _ = await navigate("where", *flags)
        wrong, _, err = await navigate("plan", "r-5301", "r-53133", *flags)
    assert code == 0
    assert json.loads(out)["via"][-1] == "r-5313"
    assert "give or take" in where
    assert wrong == 2
    assert "Did you mean 'r-5313'" in err


async def test_the_command_line_says_first_that_no_robot_was_heard_or_that_it_is_lost():
    navigator = Navigator(Floor(load_plan()))
    async with bus() as options:
        service = NavigateService(navigator, options)
        robot = Module("robot", options=options)
        flags = ("--connect", options.connect, "--realm", options.realm)
        async with robot, running(service.run()):
            await robot.wait_for(WhereAmI, timeout=10)
            _, unheard, _ = await navigate("where", *flags)
            _, stopped_unheard, _ = await navigate("stop", *flags)
            await robot.broadcast(reading(1))
            await eventually(lambda: navigator.position().heard)
            navigator.localizer.widen(spread=15.0, turn_spread=2.0)
            _, lost, _ = await navigate("where", *flags)
            _, stopped, _ = await navigate("stop", *flags)
            _, told, _ = await navigate("where", "--json", *flags)
    assert unheard.startswith("no robot has been heard yet: it is taken to be at (7.57, 12.00) m")
    assert stopped_unheard.startswith("stopped; no robot has been heard yet")
    assert lost.startswith("lost: it may be at (")
    assert "give or take" not in unheard + lost
    assert stopped.startswith("stopped; lost: it may be at (")
    assert json.loads(told)["lost"] is True


async def test_bad_maps_and_missing_buses_have_their_exit_codes(tmp_path):
    broken = tmp_path / "floor.yaml"
    broken.write_text("name: [")
    bad, _, says = await navigate("run", "--map", str(broken))
    seed, _, _ = await navigate("run", "--seed", "-1")
    gone, _, _ = await navigate("where", "--connect", "tcp/127.0.0.1:9")
    offline, out, _ = await navigate("plan", "r-5301", "r-5303", "--map", "wean5")
    assert (bad, seed, gone, offline) == (2, 2, 5, 0)
    assert "cannot be read as YAML" in says
    assert "d-5303" in out


@pytest.mark.parametrize(("start", "lost"), [("known", False), ("anywhere", True)])
async def test_it_goes_on_from_what_was_kept_unless_the_robot_may_be_anywhere(
    start, lost, tmp_path
):
    before = Navigator(Floor(load_plan()))
    before.set_position("r-5303")
    StateFile(tmp_path).save(before.snapshot())
    async with bus() as options, Module("asker", options=options) as asker:
        flags = ("--connect", options.connect, "--realm", options.realm)
        words = ("run", "--start", start, "--data", str(tmp_path), *flags)
        async with running(run_command(app, *words)):
            await asker.wait_for(WhereAmI, timeout=20)
            position = await asker.query(WhereAmI())
    assert position.lost is lost
    assert (position.room == "r-5303") is not lost


async def test_a_localizer_that_cannot_start_anywhere_is_refused():
    code, _, says = await navigate("run", "--start", "anywhere", "--localizer", "particles")
    assert code == 2
    assert "--start is 'anywhere', expected known, or --localizer pomdp" in says


@pytest.mark.process
async def test_the_process_serves_until_it_is_told_to_stop(tmp_path):
    async with bus() as options, Module("asker", options=options) as asker:
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            *("-m", "navigate", "run", "--data", str(tmp_path)),
            env={**os.environ, "TCA_CONNECT": options.connect, "TCA_REALM": options.realm},
            stderr=asyncio.subprocess.DEVNULL,
        )
        await asker.wait_for(NavigateToGoal, timeout=20)
        assert len(await asker.query(Rooms())) == 60
        process.send_signal(signal.SIGTERM)
        assert await process.wait() == 0
