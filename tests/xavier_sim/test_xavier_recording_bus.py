"""Recording a robot that runs on the bus, and one whose process is killed."""

from __future__ import annotations

import asyncio
import sys

import pytest

from tca_bus import Module
from tca_bus.testing import bus, eventually
from xavier_sim.cli._app import beginning_of
from xavier_sim.floors import load_floor
from xavier_sim.messages import DoorMoved, Drive, MoveDoor, PlateReading, ReadPlate, Sensors
from xavier_sim.recording import Recorder, RecordingReader, decode
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.world import World

PLAN = load_floor()


def messages_of(path, *kinds):
    with RecordingReader(path) as reader:
        entries = [decode(entry.name, entry.payload) for entry in reader]
    return reader, [message for message in entries if isinstance(message, kinds)]


@pytest.mark.bus
async def test_what_the_driver_saw_and_said_is_recorded(tmp_path):
    path, seen = tmp_path / "drive.mcap", {}
    state = RobotState(World(PLAN, seed=2), SimClock(1000.0), speed=None)
    async with bus() as options, Module("navigate", options=options) as driver:

        @driver.handler(Sensors)
        async def drive(sensors, context):
            seen[sensors.tick] = sensors
            busy, turn = sensors.tick < 30, 0.1 * (sensors.tick % 3)
            await driver.inform(Drive(tick=sensors.tick, speed=0.3, turn_rate=turn, busy=busy))

        async with Recorder(path, beginning_of(state)) as recorder:
            robot = asyncio.create_task(RobotModule(state, None, options, recorder).run())
            await eventually(lambda: state.world.tick == 30)
            await driver.query(MoveDoor(room="r-5309", open=False))
            plate = await driver.query(ReadPlate())
            robot.cancel()
            await asyncio.gather(robot, return_exceptions=True)
    reader, sensed = messages_of(path, Sensors)
    assert reader.is_finished
    assert [sensors.tick for sensors in sensed] == list(range(31))
    assert seen
    for sensors in sensed:
        heard = seen.get(sensors.tick, sensors)
        assert heard.model_dump_json() == sensors.model_dump_json()
        assert heard.sonar.tobytes() == sensors.sonar.tobytes()
    _, driven = messages_of(path, Drive)
    assert [(one.tick, one.turn_rate) for one in driven] == [
        (tick, 0.1 * (tick % 3)) for tick in range(30)
    ]
    _, others = messages_of(path, DoorMoved, PlateReading)
    assert others == [DoorMoved(room="r-5309", open=False, time=state.now), plate]


@pytest.mark.process
async def test_a_robot_killed_by_force_leaves_a_readable_beginning(tmp_path):
    path = tmp_path / "killed.mcap"
    async with bus() as options, Module("navigate", options=options) as driver:
        ticks = []

        @driver.handler(Sensors)
        async def drive(sensors, context):
            ticks.append(sensors.tick)
            await driver.inform(Drive(tick=sensors.tick, speed=0.3, turn_rate=0.0, busy=True))

        flags = ("--connect", options.connect, "--realm", options.realm)
        robot = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "xavier_sim", "run", "--speed", "max", *flags),
            *("--seed", "3", "--record", str(path)),
        )
        try:
            await eventually(lambda: path.exists() and path.stat().st_size > 20_000)
        finally:
            robot.kill()
            await robot.wait()
    reader, sensed = messages_of(path, Sensors)
    assert not reader.is_finished
    assert len(sensed) > 10
    assert [sensors.tick for sensors in sensed] == list(range(len(sensed)))
    assert sensed[-1].tick <= ticks[-1]
