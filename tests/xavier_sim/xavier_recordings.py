"""A recording of a short drive, and what it was made of, for tests."""

from __future__ import annotations

import math

import numpy as np

from tca_bus import TaskStatus
from xavier_sim.cli._recording import beginning_of
from xavier_sim.floors import load_floor
from xavier_sim.messages import CameraPower, DoorMoved, Drive, Fault, PlateReading, Sensors
from xavier_sim.recording import RecordingReader, Tape
from xavier_sim.recording._heard import (
    Belief,
    BeliefState,
    BelievedCell,
    BelievedPose,
    DriveState,
    Progress,
)
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

PLAN = load_floor()
TICKS = 40


def fresh_state(seed=1):
    return RobotState(World(PLAN, seed=seed), SimClock(1000.0), speed=None)


def status(**fields):
    base = {
        "id": "t1",
        "name": "navigateToG",
        "task_class": "goal",
        "sender": "rogue",
        "parent": None,
        "state": "active",
        "handling": "handling",
        "planning": "planning",
        "achievement": "achieving",
        "existence": "alive",
        "created": 1000.0,
        "sequence": 1,
        "data": {"x": math.inf},
    }
    return TaskStatus(**{**base, **fields})


def belief(time):
    at = BelievedPose(x=5.0, y=12.0, theta=1.5, deviation=0.1, time=time)
    cells = [BelievedCell(x=5.0, y=12.0, theta=1.5, mass=0.8)]
    state = BeliefState(position=at, entropy=0.7, lost=False, goal_mass=0.25, cells=tuple(cells))
    return Belief(state=state)


def progress():
    drive = DriveState(
        task="t1", x=500.0, y=1200.0, room="r-5303", metres_left=7.5, seconds_left=12.0,
        metres=1.0, seconds=3.0, recoveries=1, goal_mass=0.25, faults={"sonar 3": "dead"},
    )  # fmt: skip
    return Progress(drive=drive)


def things(state):
    """What a short drive tells its witness: pairs of a message and its time."""
    for tick in range(TICKS):
        yield state.sensors(), state.true_location()
        if tick == 7:
            state.world.set_door("r-5309", is_open=False)
            yield DoorMoved(room="r-5309", open=False, time=state.now, door="d-5309"), state.now
        if tick == 9:
            yield PlateReading(text="r-5303", confidence=0.9, time=state.now), state.now
            yield Fault(fault=CameraPower(on=False)), state.now
        yield Drive(tick=state.world.tick, speed=0.4, turn_rate=0.3, busy=True), state.now
        state.world.step(0.4, 0.3)


def write(stream, *, flush_every=1):
    """Write a recording; gives the messages in it."""
    state, told = fresh_state(), []
    tape = Tape(stream, beginning_of(state))
    for number, (message, more) in enumerate(things(state)):
        told.append(message)
        if isinstance(message, Sensors):
            tape.sense(message, more)
            told.append(more)
        else:
            tape.note(message, more)
        if number % flush_every == 0:
            tape.flush()
    told.append(belief(state.now - 0.1))
    tape.believe(told[-1])
    tape.advance(progress())
    tape.hear(status())
    message, more = state.sensors(), state.true_location()
    tape.sense(message, more)
    told += [message, more]
    tape.finish(dropped=3)
    return told


def read(path):
    with RecordingReader(path) as reader:
        entries = list(reader)
    return reader, entries


def same(one, other):
    if type(one) is not type(other):
        return False
    return all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in type(one).model_fields
    )


def damaged(path, folder):
    """A copy with a byte in the middle of a chunk changed."""
    data = bytearray(path.read_bytes())
    chunk = data.index(b"\x06", len(data) // 2)
    while data[chunk + 9 + 28 : chunk + 9 + 28 + 8] != b"\x04\0\0\0zstd":
        chunk = data.index(b"\x06", chunk + 1)
    data[chunk + 90] ^= 0xFF
    copy = folder / "damaged.mcap"
    copy.write_bytes(data)
    return copy
