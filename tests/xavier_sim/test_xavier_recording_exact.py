"""The same world and commands give the same sensors to the bit: elsewhere, later, at any speed."""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import subprocess
import sys
from collections import Counter
from importlib import import_module
from pathlib import Path
from xml.etree.ElementTree import fromstring

import pytest
from xavier_recordings import PLAN, TICKS, read, write

from tca_bus import Module
from tca_bus.testing import bus, eventually
from xavier_sim.cli._recording import beginning_of
from xavier_sim.messages import Drive, Fault, MoveDoor, Sensors, SonarFault
from xavier_sim.profile import PROFILES
from xavier_sim.recording import (
    Recorder,
    RecordingFileError,
    RecordingReader,
    RetraceError,
    Tape,
    retrace,
)
from xavier_sim.running import RobotModule, RobotState, SimClock, make_fault
from xavier_sim.world import World


def again(path):
    with RecordingReader(path) as reader:
        return retrace(reader, make_fault=make_fault, rays="numpy")


def sensor_log(path):
    """A hash of all sensor readings as they were on the wire."""
    digest = hashlib.sha256()
    for entry in read(path)[1]:
        if entry.name == Sensors.wire_name:
            digest.update(entry.payload.data)
    return digest.hexdigest()


def wheels(tick):
    return 0.5, 0.9 * (-1) ** (tick // 8)


def write_drive(path, state, ticks):
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        for _ in range(ticks):
            tape.sense(state.sensors(), state.true_location())
            speed, turn = wheels(state.tick)
            tape.note(Drive(tick=state.tick, speed=speed, turn_rate=turn, busy=True), state.now)
            state.world.step(speed, turn)
        tape.finish(dropped=0)


def make_state(profile="hard", **crowd):
    world = World(PLAN, 5, PROFILES[profile], **crowd)
    return RobotState(world, SimClock(1000.0), speed=None)


def test_a_recording_with_doors_and_faults_comes_out_the_same(tmp_path):
    path = tmp_path / "drive.mcap"
    with path.open("wb") as stream:
        write(stream)
    assert again(path) == TICKS + 1


@pytest.mark.parametrize("profile", ["hard", "modern"])
def test_people_and_carts_come_out_the_same(tmp_path, profile):
    path = tmp_path / "crowd.mcap"
    write_drive(path, make_state(profile, people=6, carts=3), 60)
    assert again(path) == 60


def test_a_recording_that_begins_in_the_middle_comes_out_the_same(tmp_path):
    path, state = tmp_path / "late.mcap", make_state(people=4)
    for tick in range(70):
        state.world.step(*wheels(tick))
    write_drive(path, state, 50)
    assert again(path) == 50


def test_a_world_resumed_from_a_snapshot_gives_the_log_of_one_that_was_not(tmp_path):
    whole, part, state = tmp_path / "whole.mcap", tmp_path / "part.mcap", make_state(people=4)
    for tick in range(30):
        state.world.step(*wheels(tick))
    kept = json.loads(json.dumps(state.world.snapshot()))
    write_drive(whole, state, 60)
    other = make_state(people=4)
    other.world.restore(kept)
    write_drive(part, other, 60)
    assert sensor_log(part) == sensor_log(whole)


def test_another_command_gives_another_log(tmp_path):
    path, state = tmp_path / "wrong.mcap", make_state()
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        for tick in range(6):
            tape.sense(state.sensors(), state.true_location())
            drive = Drive(tick=tick, speed=0.5, turn_rate=0.0, busy=True)
            tape.note(drive, state.now)
            state.world.step(0.5, 0.0 if tick < 4 else 1e-3)
        tape.finish(dropped=0)
    with pytest.raises(RetraceError, match=r"comes out otherwise here: \w+ at tick 5"):
        again(path)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"robots": {}}, "is of a world with 0 robots"),
        ({"doors": None}, "begins with a world that cannot be restored here"),
        ({}, "has no whole tick in it"),
    ],
)
def test_a_world_that_cannot_be_simulated_again_is_a_clear_error(tmp_path, change, says):
    path, state = tmp_path / "other.mcap", make_state()
    beginning = beginning_of(state)
    world = {**beginning.world, **change}
    with path.open("wb") as stream:
        Tape(stream, beginning.model_copy(update={"world": world})).finish(dropped=0)
    with pytest.raises(RecordingFileError, match=says):
        again(path)


@pytest.mark.slow
def test_the_picture_of_the_documents_comes_out_of_a_recording(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "docs")
    picture = fromstring(import_module("recording_picture").draw_recording())
    styles = Counter(shape.get("class") for shape in picture.iter())
    assert styles["cone"] > 30
    assert styles["body"] == 3
    assert styles["walls"] > 100
    assert styles["truth"] == styles["reckoned"] == 2


@pytest.mark.process
async def test_what_ran_by_the_clock_comes_out_the_same_in_another_process(tmp_path):
    """By the clock the driver comes late now and then: what counts is what the wheels were told."""
    path, state = tmp_path / "paced.mcap", make_state(people=4)
    state.speed = 20.0
    async with bus() as options, Module("navigate", options=options) as driver:

        @driver.handler(Sensors)
        async def drive(sensors, context):
            speed, turn = wheels(sensors.tick)
            command = Drive(tick=sensors.tick, speed=speed, turn_rate=turn, busy=True)
            await driver.inform(command)

        async with Recorder(path, beginning_of(state)) as recorder:
            robot = asyncio.create_task(RobotModule(state, None, options, recorder).run())
            await eventually(lambda: state.tick > 15)
            await driver.query(MoveDoor(room="r-5309", open=False))
            await driver.query(Fault(fault=SonarFault(number=3, state="stuck", metres=1.5)))
            await eventually(lambda: state.tick > 40)
            robot.cancel()
            await asyncio.gather(robot, return_exceptions=True)
    done = await asyncio.to_thread(
        subprocess.run,
        [sys.executable, "-m", "xavier_sim", "verify", str(path), "--json", "--rays", "numpy"],
        env={**os.environ, "PYTHONHASHSEED": "7"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"ticks": state.tick + 1, "complete": True}
