"""The processes of the robot, spawned and killed as a user does it."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from contextlib import asynccontextmanager

import pytest
from command_line import run_command

from tca_bus import BusOptions, Module
from tca_bus.testing import bus, eventually
from xavier_sim.cli import app
from xavier_sim.floors import load_floor
from xavier_sim.messages import Ask, Drive, Sensors, WhereReally

pytestmark = pytest.mark.process

PLAN = load_floor()


def spawn(options, *words, **more):
    flags = ["--connect", options.connect, "--realm", options.realm]
    command = [sys.executable, "-m", "xavier_sim", *words, *flags]
    return asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE, **more
    )


@asynccontextmanager
async def process(options, *words, **more):
    child = await spawn(options, *words, **more)
    try:
        yield child
    finally:
        if child.returncode is None:
            child.send_signal(signal.SIGTERM)
        await child.communicate()


async def run(options, *words):
    ran = await run_command(app, *words, TCA_CONNECT=options.connect, TCA_REALM=options.realm)
    return ran.code, ran.out, ran.err


async def test_killed_robot_goes_on_where_it_was(tmp_path):
    arguments = ("run", "--speed", "max", "--seed", "3", "--data", str(tmp_path))
    async with bus() as options, Module("navigate", options=options) as driver:
        times = []

        @driver.handler(Sensors)
        async def drive(sensors, context):
            times.append(sensors.time)
            await driver.inform(Drive(tick=sensors.tick, speed=0.4, turn_rate=0.0, busy=True))

        async with process(options, *arguments) as first:
            await eventually(lambda: len(times) > 150)
            assert (await driver.query(WhereReally())).metres > 3.0
            first.kill()
            await first.wait()
        before, told = len(times), max(times)
        async with process(options, *arguments):
            await eventually(lambda: len(times) > before + 3)
            assert times[before] > told
            assert (await driver.query(WhereReally())).metres > 1.0


async def test_commands_of_the_robot(tmp_path):
    async with (
        bus() as options,
        Module("asker", options=options) as asker,
        process(options, "run", "--seed", "1") as robot,
    ):
        await asker.wait_for(WhereReally, timeout=20)
        code, out, _ = await run(options, "where", "--json")
        assert code == 0
        assert json.loads(out)["space"] == "foyer"
        code, out, _ = await run(options, "door", "R-5303", "close", "--json")
        assert code == 0
        assert json.loads(out) == {"room": "r-5303", "open": False, "door": "d-5303"}
        assert (await run(options, "door", "D-5303", "open"))[0] == 0
        code, _, err = await run(options, "door", "r-53003", "close")
        assert code == 2
        assert "Did you mean 'r-5303'" in err
        code, _, err = await run(options, "fault", "kidnap", "r-53003")
        assert code == 2
        assert "Did you mean 'r-5303'" in err
        kidnap, there, _ = await run(options, "fault", "kidnap", "R-5305", "--json")
        slip, out, _ = await run(options, "fault", "odometry", "-3.6")
        place, _, err = await run(options, "fault", "kidnap", "--x", "3")
        assert (kidnap, slip, place) == (0, 0, 2)
        assert json.loads(there)["room"] == "r-5305"
        assert "-3.600 m to count wrongly" in out
        assert "expected both x and y" in err
        robot.send_signal(signal.SIGTERM)
        await robot.wait()
        assert robot.returncode == 0


async def test_no_robot_there():
    async with bus() as options:
        code, _, err = await run(options, "where")
        assert code == 3
        assert "xavierTrueLocation" in err


async def test_bad_flag_is_one_clear_line():
    code, _, err = await run(BusOptions(), "run", "--map", "wean6")
    assert code == 2
    assert err.startswith("error: wean6: map is 'wean6', expected a floor plan file")
    assert "Did you mean 'wean5'" in err


async def test_survey_writes_a_map(tmp_path):
    file = tmp_path / "map.yaml"
    assert (await run_command(app, "survey", "wean5", "--seed", "3", "-o", str(file))).code == 0
    assert load_floor(str(file)).places == PLAN.places
    nowhere = await run_command(app, "survey", "wean5", "-o", "/")
    assert (nowhere.code, nowhere.err) == (2, "error: / is no file; give the name of one\n")


async def test_keyboard_process_on_a_terminal():
    master, slave = os.openpty()
    async with bus() as options, Module("asker", options=options) as asker:
        words = ("speech", "--people", "keyboard")
        async with process(options, *words, stdin=slave) as speech:
            await asker.wait_for(Ask, timeout=20)
            speech.send_signal(signal.SIGTERM)
            await speech.wait()
            assert speech.returncode == 0
    os.close(master)
    os.close(slave)
