"""Recording a robot that runs on the bus, and one whose process is killed."""

from __future__ import annotations

import asyncio
import json
import signal
import sys

import pytest
from mcap.reader import make_reader

from navigate.messages import Belief, BeliefCell, BeliefState, DriveProgress, Position, Progress
from tca_bus import Command, Module
from tca_bus.testing import bus, central, eventually
from xavier_sim.cli._recording import beginning_of
from xavier_sim.floors import load_floor
from xavier_sim.messages import DoorMoved, Drive, MoveDoor, PlateReading, ReadPlate, Sensors
from xavier_sim.recording import Recorder, RecordingReader, decode, listening
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
    assert others == [DoorMoved(room="r-5309", open=False, time=state.now, door="d-5309"), plate]


class Listener(Recorder):
    """A recorder that knows what it has heard."""

    def __init__(self, path, beginning):
        super().__init__(path, beginning)
        self.heard = set()

    def believe(self, belief):
        super().believe(belief)
        self.heard.add("belief")

    def advance(self, progress):
        super().advance(progress)
        self.heard.add("progress")

    def hear(self, status):
        super().hear(status)
        self.heard.add(status.state)


class Wink(Command[None]):
    wire_name = "C_wink"


def shown(path, topic):
    with path.open("rb") as stream:
        messages = make_reader(stream).iter_messages(topics=[topic])
        return [json.loads(message.data) for _, _, message in messages]


@pytest.mark.bus
async def test_what_others_say_is_recorded(tmp_path):
    """The messages are the navigator's own: the recorder knows them by their names only."""
    path = tmp_path / "heard.mcap"
    state = RobotState(World(PLAN, seed=2), SimClock(1000.0), speed=None)
    at = {"x": 5.0, "y": 12.0, "theta": 1.5, "deviation": 0.1, "heading_deviation": 0.1}
    position = Position(**at, room=None, time=1000.0)
    cells = (BeliefCell(x=5.0, y=12.0, theta=1.5, mass=0.8),)
    told = BeliefState(position=position, entropy=0.5, lost=False, goal_mass=0.25, cells=cells)
    driven = DriveProgress(
        task="t1", x=500.0, y=1200.0, room=None, metres_left=7.5, seconds_left=None,
        metres=1.0, seconds=3.0, recoveries=2, goal_mass=0.25, time=1000.0,
    )  # fmt: skip
    async with (
        bus() as options,
        central(options),
        Module("navigate", options=options) as navigator,
        Listener(path, beginning_of(state)) as recorder,
    ):

        @navigator.handler(Wink)
        async def wink(command, context):
            return None

        async with listening(recorder, options):
            await recorder.sense(state.sensors(), state.true_location())
            await navigator.wait_for(Wink, timeout=10)

            async def is_heard():
                await navigator.broadcast(Belief(state=told))
                await navigator.broadcast(Progress(drive=driven))
                return {"belief", "progress"} <= recorder.heard

            await eventually(is_heard)
            await navigator.execute(Wink(), id="wink-1")
            await eventually(lambda: "achieved" in recorder.heard)
    beliefs, tasks = shown(path, "/belief"), shown(path, "/tasks")
    assert beliefs[0]["entropy"] == 0.5
    assert beliefs[0]["goal_mass"] == 0.25
    drives = shown(path, "/progress")
    assert (drives[0]["task"], drives[0]["metres_left"], drives[0]["recoveries"]) == ("t1", 7.5, 2)
    assert beliefs[0]["cells"] == [{"x": 5.0, "y": 12.0, "theta": 1.5, "mass": 0.8}]
    assert {(task["id"], task["name"]) for task in tasks} == {("wink-1", "C_wink")}


@pytest.mark.process
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
async def test_a_robot_that_is_stopped_leaves_all_and_one_that_is_killed_a_beginning(tmp_path, end):
    path = tmp_path / "ended.mcap"
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
            robot.send_signal(end)
            await robot.wait()
    reader, sensed = messages_of(path, Sensors)
    assert reader.is_finished == (end == signal.SIGTERM)
    assert len(sensed) > 10
    assert [sensors.tick for sensors in sensed] == list(range(len(sensed)))
    # One more may have been on its way to the driver.
    assert sensed[-1].tick <= ticks[-1] + 1
