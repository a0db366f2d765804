"""A room with two doors: each is moved, told, shown and recorded by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from tca_bus import Module
from tca_bus.testing import bus, eventually
from xavier_sim.cli._recording import beginning_of
from xavier_sim.floors import load_floor
from xavier_sim.messages import Corner, Door, DoorMoved, DoorState, Drive, MoveDoor, WorldDoors
from xavier_sim.recording import RecordedRobot, RecordingReader, Tape, retrace
from xavier_sim.running import RobotModule, RobotState, SimClock, make_fault
from xavier_sim.world import World

COTTAGE = load_floor(str(Path(__file__).parent / "soak_floor.yaml"))
SECOND = Door(name="east-1", between=("hall", "r-1"), at=Corner(x=3.0, y=2.4))
PLAN = COTTAGE.model_copy(update={"doors": (*COTTAGE.doors, SECOND)})


@pytest.fixture
def state():
    return RobotState(World(PLAN, 1), SimClock(1000.0), speed=None)


def test_the_room_is_shut_when_both_are(state):
    assert state.world.set_door("r-1", is_open=False) == ("d-1", "r-1", False)
    assert state.world.doors()["r-1"]
    assert state.world.set_door("east-1", is_open=False) == ("east-1", "r-1", False)
    assert not state.world.doors()["r-1"]


@pytest.mark.bus
async def test_each_is_told_by_its_own_name(state):
    heard = []
    async with bus() as options, Module("asker", options=options) as asker:

        @asker.handler(DoorMoved)
        async def hear(moved, context):
            heard.append((moved.door, moved.room, moved.open))

        robot = asker.start(RobotModule(state, None, options).run(), name="robot")
        await asker.wait_for(MoveDoor, timeout=10)
        first = await asker.query(MoveDoor(room="r-1", open=False))
        second = await asker.query(MoveDoor(room="east-1", open=False))
        states = await asker.query(WorldDoors())
        await eventually(lambda: len(heard) == 2)
        robot.cancel()
    assert (first.door, second) == ("d-1", DoorState(room="r-1", open=False, door="east-1"))
    assert heard == [("d-1", "r-1", False), ("east-1", "r-1", False)]
    assert [one.door for one in states if not one.open] == ["d-1", "east-1"]


async def test_each_is_recorded_by_itself(state, tmp_path):
    path = tmp_path / "doors.mcap"
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        for tick in range(20):
            tape.sense(state.sensors(), state.true_location())
            if tick == 3:
                door = state.world.set_door("east-1", is_open=False)
                told = DoorMoved(room=door.room, open=False, time=state.now, door=door.name)
                tape.note(told, state.now)
            tape.note(Drive(tick=tick, speed=0.3, turn_rate=0.5, busy=True), state.now)
            state.world.step(0.3, 0.5)
        tape.finish(dropped=0)
    with RecordingReader(path) as reader:
        assert retrace(reader, make_fault=make_fault) == 20
    with RecordingReader(path) as reader:
        robot = await RecordedRobot.open(reader, speed=None)
        while not robot.is_over:
            await robot.advance(0.0, 0.0)
        assert [one.door for one in robot.door_states() if not one.open] == ["east-1"]
