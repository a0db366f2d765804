"""Recordings that are played to a navigator in place of a world."""

from __future__ import annotations

import asyncio
import json
import sys

import numpy as np
import pytest
from xavier_recordings import PLAN, TICKS, damaged, same, write

from navigate.maps import Floor, load_plan
from navigate.messages import NavigateToGoal
from navigate.navigator import Navigator
from navigate.service import NavigateService
from tca_bus import HandlerFailedError, Module
from tca_bus.testing import bus, central, eventually
from xavier_sim.cli._recording import beginning_of
from xavier_sim.messages import (
    CameraPower,
    DoorMoved,
    Drive,
    Fault,
    MoveDoor,
    PlateReading,
    ReadPlate,
    Sensors,
    TrueLocation,
    WhereReally,
    WorldDoors,
)
from xavier_sim.recording import (
    RecordedRobot,
    Recorder,
    RecordingFileError,
    RecordingReader,
    Tape,
    ticks_of,
)
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.world import World


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("replay") / "drive.mcap"
    with path.open("wb") as stream:
        told = write(stream)
    return path, told


def ticks(path):
    with RecordingReader(path) as reader:
        return list(ticks_of(reader, path))


async def played(path, **options):
    """Every tick that a recorded robot comes to."""
    with RecordingReader(path) as reader:
        robot = await RecordedRobot.open(reader, **{"speed": None, **options})
        sensed = [robot.sensors()]
        while not robot.is_over:
            await robot.advance(0.7, 0.7)
            sensed.append(robot.sensors())
    return sensed


async def test_a_recorded_robot_senses_what_it_sensed_then(recording):
    path, told = recording
    recorded = [message for message in told if isinstance(message, Sensors)]
    assert all(map(same, await played(path), recorded))
    paced = await played(path, speed=2.0)
    assert [sensors.tick for sensors in paced] == [sensors.tick for sensors in recorded]
    assert not any(sensors.lockstep for sensors in paced)
    assert [one.sonar.tobytes() for one in paced] == [one.sonar.tobytes() for one in recorded]


def test_a_tick_holds_what_happened_in_it(recording):
    path, _ = recording
    found = ticks(path)
    assert len(found) == TICKS + 1
    assert [tick.command.tick for tick in found[:-1]] == list(range(TICKS))
    assert found[-1].command is None
    assert {tick.sensors.tick: tick.said for tick in found if tick.said} == {
        7: [DoorMoved(room="r-5309", open=False, time=found[7].sensors.time, door="d-5309")]
    }
    assert [tick.sensors.tick for tick in found if tick.plates] == [9]


async def test_what_is_whole_of_a_recording_that_was_cut_off_is_played(recording, tmp_path):
    path, _ = recording
    whole, cut = await played(path), tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    part = await played(cut)
    assert 5 < len(part) < len(whole)
    assert all(map(same, part, whole))


async def test_what_comes_before_a_damage_is_played(recording, tmp_path):
    path, _ = recording
    broken = damaged(path, tmp_path)
    with RecordingReader(broken) as reader:
        robot = await RecordedRobot.open(reader, speed=None)

        async def play_on():
            while not robot.is_over:
                await robot.advance(0.0, 0.0)

        with pytest.raises(RecordingFileError, match="is damaged after"):
            await play_on()
        assert robot.played > 5


async def test_a_recording_without_a_tick_is_a_clear_error(tmp_path):
    path = tmp_path / "empty.mcap"
    state = RobotState(World(PLAN), SimClock(0.0), speed=None)
    with path.open("wb") as stream:
        Tape(stream, beginning_of(state)).finish(dropped=0)
    with pytest.raises(RecordingFileError, match="has no whole tick in it"):
        await played(path)


async def test_a_message_that_is_not_what_it_should_be_is_a_clear_error(tmp_path):
    path = tmp_path / "wrong.mcap"
    state = RobotState(World(PLAN), SimClock(0.0), speed=None)
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        tape.sense(state.sensors(), state.true_location())
        wrong = Drive.model_construct(tick=-1, speed=0.0, turn_rate=0.0, busy=False)
        tape.note(wrong, 0.0)
        tape.finish(dropped=0)
    with pytest.raises(RecordingFileError, match=r"cannot be played from record \d+ on: .*tick"):
        await played(path)


async def test_sensors_of_wrong_length_are_a_clear_error(tmp_path):
    path = tmp_path / "short.mcap"
    state = RobotState(World(PLAN), SimClock(0.0), speed=None)
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        short = {"sonar": np.zeros(23, np.float32), "sonar_fresh": 0}
        tape.sense(state.sensors().model_copy(update=short), state.true_location())
        tape.finish(dropped=0)
    with pytest.raises(RecordingFileError, match=r"sonar: has shape \(23,\), expected \(24,\)"):
        await played(path)


class Driver:
    """Answers each tick, and remembers what it heard."""

    def __init__(self, options, *, busy=False):
        self.module, self.heard, self.busy = Module("navigate", options=options), [], busy
        self.doors, self.answered = [], 0
        self.module.serve(Sensors, self.on_sensors)
        self.module.serve(DoorMoved, self.on_door)

    async def on_sensors(self, sensors, context):
        self.heard.append(sensors)
        drive = Drive(tick=sensors.tick, speed=0.0, turn_rate=0.0, busy=self.busy)
        await self.module.inform(drive)
        self.answered += 1

    async def on_door(self, moved, context):
        self.doors.append((self.heard[-1].tick, moved.room, moved.open))


@pytest.mark.bus
@pytest.mark.parametrize("speed", [None, 40.0])
async def test_a_replay_gives_the_driver_the_recorded_sensors(recording, speed):
    path, told = recording
    async with bus(clock="sim") as options:
        driver = Driver(options)
        with RecordingReader(path) as reader:
            async with driver.module:
                robot = await RecordedRobot.open(reader, speed=speed)
                await RobotModule(robot, None, options).run()
                await eventually(lambda: driver.heard[-1].tick == TICKS and driver.doors)
    heard = {sensors.tick: sensors for sensors in driver.heard}
    recorded = [message for message in told if isinstance(message, Sensors)]
    assert len(heard) == TICKS + 1 if speed is None else heard
    for sensors in heard.values():
        as_recorded = recorded[sensors.tick].model_copy(update={"lockstep": speed is None})
        assert same(sensors, as_recorded)
    assert driver.doors == [(7, "r-5309", False)]
    assert robot.played == TICKS + 1


@pytest.mark.bus
async def test_a_replay_waits_for_a_goal_where_there_was_one_and_answers_questions(recording):
    path, told = recording
    async with bus() as options:
        driver = Driver(options)
        with RecordingReader(path) as reader:
            robot = await RecordedRobot.open(reader, speed=None, goals=True)
            running = asyncio.create_task(RobotModule(robot, None, options).run(), name="robot")
            async with driver.module as asker:
                # Sensors may be heard before it is known who sends them and what it serves.
                await eventually(lambda: driver.answered > 1)
                assert robot.tick == 0
                truth = next(one for one in told if isinstance(one, TrueLocation))
                assert await asker.query(WhereReally()) == truth
                assert all(door.open for door in await asker.query(WorldDoors()))
                for change in (
                    MoveDoor(room="r-5309", open=False),
                    Fault(fault=CameraPower(on=False)),
                ):
                    with pytest.raises(HandlerFailedError, match="is a recording"):
                        await asker.query(change)
                with pytest.raises(HandlerFailedError, match="nobody asked the camera"):
                    await asker.query(ReadPlate())
                driver.busy = True
                await running
    assert robot.is_over
    doors = {door.room: door.open for door in robot.door_states()}
    assert not doors["r-5309"]


async def test_the_camera_reads_again_what_it_read_at_that_tick(recording):
    path, told = recording
    reading = next(message for message in told if isinstance(message, PlateReading))
    with RecordingReader(path) as reader:
        robot = await RecordedRobot.open(reader, speed=None)
        while robot.tick < 9:
            assert robot.plate() is None
            await robot.advance(0.0, 0.0)
        assert [robot.plate(), robot.plate()] == [reading, reading]


class Wheels:
    """Takes down what the wheels are told."""

    def __init__(self):
        self.sensed, self.commands = [], []

    async def sense(self, sensors, truth, standing):
        self.sensed.append(sensors)

    def note(self, message, time):
        if isinstance(message, Drive):
            self.commands.append(message)


async def drive_to(room, plant, witness):
    """Let a fresh navigator drive a robot to a room, on a bus of their own."""
    navigator = Navigator(Floor(load_plan()), seed=4)
    async with (
        bus(clock="sim") as options,
        central(options),
        Module("asker", options=options) as asker,
        asyncio.TaskGroup() as group,
    ):
        served = (NavigateService(navigator, options), RobotModule(plant, None, options, witness))
        tasks = [group.create_task(one.run(), name="served") for one in served]
        await asker.wait_for(NavigateToGoal, WhereReally, timeout=10)
        x, y = navigator.floor.place(room)
        task = await asker.expand(NavigateToGoal(x=100 * x, y=100 * y))
        report = await task.result(timeout=30)
        for running in tasks:
            running.cancel()
    return report


@pytest.mark.bus
async def test_the_navigator_drives_a_recording_as_it_drove_the_world(tmp_path):
    path, wheels = tmp_path / "drive.mcap", Wheels()
    state = RobotState(World(PLAN, seed=1), SimClock(1000.0), speed=None)
    async with Recorder(path, beginning_of(state)) as recorder:
        report = await drive_to("r-5301", state, recorder)
    with RecordingReader(path) as reader:
        again = await RecordedRobot.open(reader, speed=None, goals=True)
        replayed = await drive_to("r-5301", again, wheels)
    recorded = ticks(path)
    assert len(recorded) > 100
    assert report == replayed
    assert len(wheels.sensed) == len(recorded)
    assert all(map(same, wheels.sensed, [tick.sensors for tick in recorded]))
    assert wheels.commands == [tick.command for tick in recorded if tick.command]


@pytest.mark.process
async def test_the_command_plays_a_recording_to_its_end(recording, tmp_path):
    path, _ = recording
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    async with bus() as options:
        driver = Driver(options)

        async def replay(file):
            flags = ("--connect", options.connect, "--realm", options.realm)
            child = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "xavier_sim", "replay", str(file), "--speed", "max"),
                *("--json", *flags),
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.PIPE,
            )
            out, err = await child.communicate()
            return child.returncode, out.decode(), err.decode()

        async with driver.module:
            code, out, err = await replay(cut)
            assert code == 0, err
            told = json.loads(out)
            assert told == {"ticks": driver.heard[-1].tick + 1, "complete": False}
            assert "was cut off; all that is whole in it was played" in err
            code, _, err = await replay(tmp_path / "none.mcap")
    assert code == 2
    assert "none.mcap cannot be opened" in err
