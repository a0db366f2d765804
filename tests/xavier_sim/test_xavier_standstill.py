"""Time that stands still for somebody says for whom, and a replay does not do so for ever."""

from __future__ import annotations

import asyncio
import logging
import math

import pytest
from command_line import run_command
from test_xavier_bus import StandIn, robot, sim
from xavier_recordings import write

from tca_bus import Module
from tca_bus.testing import bus, eventually
from xavier_sim.cli import app
from xavier_sim.messages import Drive, Sensors
from xavier_sim.recording import RecordedRobot, RecordingReader
from xavier_sim.running import RobotModule
from xavier_sim.running._standstill import SAY_AFTER, SAY_AGAIN, Standstill, StandstillError


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("standstill") / "drive.mcap"
    with path.open("wb") as stream:
        write(stream)
    return path


@pytest.fixture
def hasty(monkeypatch):
    monkeypatch.setattr("xavier_sim.running._standstill.SAY_AFTER", 0.05)


def test_a_long_wait_is_told_sparingly_and_so_is_its_end():
    still = Standstill("office")
    told = [still.look(7, "module navigate to answer", wall) for wall in range(100)]
    assert [wall for wall, word in enumerate(told) if word] == [SAY_AFTER, SAY_AFTER + SAY_AGAIN]
    assert told[5] == "realm office: tick 7 waits for module navigate to answer, 5 s now"
    assert still.end(7, 100.0) == "realm office: tick 7 goes on, after 100 s"
    assert still.end(8, 100.1) is None


def test_short_waits_are_not_told():
    still = Standstill("office")
    for tick in range(50):
        assert still.look(tick, "a goal", float(tick)) is None
        assert still.look(tick, None, tick + 0.5) is None
        assert still.look(tick, "an answer", tick + 0.6) is None
        assert still.end(tick, tick + 0.9) is None


def test_a_limit_is_for_one_thing_that_is_waited_for():
    still = Standstill("office")
    for wall in range(10):
        still.look(7, "a goal", float(wall), limit=9.0)
    still.look(7, None, 10.0, limit=9.0)
    still.look(7, "a goal", 11.0, limit=9.0)
    still.look(7, "a goal", 20.0, limit=9.0)
    with pytest.raises(StandstillError, match=r"tick 7 has waited for a goal for 9 s, in vain"):
        still.look(7, "a goal", 20.1, limit=9.0)
    still.look(7, "a goal", 1e9, limit=math.inf)


@pytest.mark.bus
async def test_a_driver_that_does_not_answer_is_named_and_so_is_that_time_goes_on(hasty, caplog):
    caplog.set_level(logging.INFO)
    async with bus() as options, robot(options) as state:
        driver = StandIn(sim(options), ticks=20)
        driver.deaf = True
        async with driver.module:
            waits = f"realm {options.realm}: tick 0 waits for module navigate to answer"
            await eventually(lambda: waits in caplog.text)
            assert state.tick == 0
            driver.deaf = False
            await driver.answer(driver.seen[-1])
            await eventually(lambda: "tick 0 goes on, after" in caplog.text)
            await eventually(lambda: state.tick == 20)


@pytest.mark.bus
async def test_a_replay_says_what_it_waits_for_and_can_be_stopped(recording, hasty, caplog):
    async with bus() as options:
        with RecordingReader(recording) as reader:
            plant = await RecordedRobot.open(reader, speed=None, goals=True)
            running = asyncio.create_task(RobotModule(plant, None, options).run(), name="robot")
            await eventually(lambda: "tick 0 waits for a module that drives" in caplog.text)
            async with StandIn(sim(options), ticks=0).module:
                await eventually(lambda: "tick 0 waits for a goal of its driver" in caplog.text)
            running.cancel()
            with pytest.raises(asyncio.CancelledError):
                await running


@pytest.mark.bus
@pytest.mark.parametrize("ends", [None, 0, 20])
async def test_a_replay_whose_goal_does_not_come_or_ends_early_ends_with_an_error(recording, ends):
    """A driver that never comes, that never has a goal, and whose goal ends before its time."""
    name = "navigate" if ends is not None else "somebody"
    async with bus() as options, Module(name, options=options) as driver:
        if ends is not None:

            @driver.handler(Sensors)
            async def answer(sensors, context):
                busy = sensors.tick < ends
                drive = Drive(tick=sensors.tick, speed=0.0, turn_rate=0.0, busy=busy)
                await driver.inform(drive)

        words = ("replay", str(recording), "--speed", "max", "--goals", "--patience", "0.3")
        ran = await run_command(app, *words, TCA_CONNECT=options.connect, TCA_REALM=options.realm)
    assert ran.code == 4
    what = "a module that drives" if ends is None else "a goal of its driver"
    assert f"error: realm {options.realm}: tick {ends or 0} has waited for {what}" in ran.err
    assert "for 0.3 s, in vain" in ran.err


async def test_a_patience_that_is_none_is_refused(recording):
    ran = await run_command(app, "replay", str(recording), "--patience", "nan")
    assert ran.code == 2
