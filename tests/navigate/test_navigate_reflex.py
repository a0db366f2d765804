"""The navigator's reflex comes before all thought; a navigator that dies leaves no runaway."""

from __future__ import annotations

import asyncio
import math
import os
import signal
import sys
from contextlib import asynccontextmanager
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from navigate_office import running
from navigate_readings import reading

from navigate.driving import STOP, Wheels, must_stop
from navigate.maps import Floor, load_plan
from navigate.messages import NavigateToGoal, WhereAmI, WhereIsRoom
from navigate.navigator import Navigator
from navigate.service._helm import Helm
from tca_bus import Module
from tca_bus.testing import bus, central
from xavier_sim.floors import load_floor
from xavier_sim.messages import BUMP_PANELS, SONAR_COUNT, Drive, Sensors, WhereReally
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.running._driver import SILENCE
from xavier_sim.world import World

BRAKING = 6
"""Ticks that the base needs to stand still."""


def sensors(*, ahead=5.0, fresh=1, **fields):
    """Readings of a robot that drives at 0.5 m/s and has just heard ahead."""
    sonar = np.full(SONAR_COUNT, 5.0, dtype=np.float32)
    sonar[0] = ahead
    return reading(sonar=sonar, sonar_fresh=fresh, speed=0.5, **fields)


@given(st.floats(-0.7, 0.7), st.integers(0, BUMP_PANELS - 1))
def test_a_touch_on_the_way_stops_and_one_behind_does_not(speed, panel):
    facing = math.cos(math.tau * panel / BUMP_PANELS)
    stops = must_stop(Wheels(speed, 0.0), sensors(bump=1 << panel))
    if speed == 0.0 or facing * speed > 0.5 * abs(speed):
        assert stops
    if facing * speed < -1e-9:
        assert not stops


@given(st.floats(0.0, 0.7), st.floats(0.25, 3.0, width=32) | st.just(0.2))
def test_what_is_heard_ahead_stops_what_could_not_brake(speed, ahead):
    room = 0.25 + ahead - 0.305 - 0.02 if ahead >= 0.25 else 0.0
    stops = must_stop(Wheels(speed, 0.0), sensors(ahead=ahead))
    if abs(speed**2 - 2.0 * room) > 1e-5:
        assert stops == (speed**2 > 2.0 * room)
    assert not must_stop(Wheels(speed, 0.0), sensors(ahead=ahead, fresh=2))
    assert not must_stop(Wheels(-speed, 0.0), sensors(ahead=ahead))


@pytest.mark.parametrize("none", [-1.0, -math.inf, math.inf, math.nan])
def test_what_is_no_range_stops_nothing(none):
    assert not must_stop(Wheels(0.5, 0.0), sensors(ahead=none))


class Listening:
    """Stands in for the module: keeps what the helm says."""

    def __init__(self):
        self.said = []

    def serve(self, *_):
        """Take any handler."""

    def modules(self):
        return [ROBOT_MODULE]

    async def inform(self, message):
        self.said.append(message)


ROBOT = SimpleNamespace(sender="xavier")
"""The context of what it sends."""
ROBOT_MODULE = SimpleNamespace(name="xavier")


async def nothing(_leapt):
    """Do nothing after a step."""


@pytest.mark.parametrize("lockstep", [False, True])
async def test_the_stop_is_said_before_the_navigator_thinks(lockstep):
    navigator, module = Navigator(Floor(load_plan())), Listening()
    failed = []
    helm = Helm(navigator, module, nothing, failed.append)
    said_before = []

    def think(_sensors):
        said_before.extend(module.said)
        navigator.wheels = Wheels(0.5, 0.0)

    navigator.step = think
    await helm._on_sensors(sensors(tick=1), ROBOT)
    module.said.clear()
    await helm._on_sensors(sensors(tick=2, ahead=0.2, lockstep=lockstep), ROBOT)
    stops = [Drive(tick=2, speed=0.0, turn_rate=0.0, busy=False)]
    assert said_before == ([] if lockstep else stops)
    assert navigator.wheels != STOP
    assert module.said[-1].tick == 2
    assert failed == []


@asynccontextmanager
async def navigate_process(options, folder):
    """The real process; killed by force if it still runs at the end."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "navigate", "run", "--data", str(folder)),
        env={**os.environ, "TCA_CONNECT": options.connect, "TCA_REALM": options.realm},
        stderr=asyncio.subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


async def until(stream, condition):
    async for message in stream:
        if condition(message):
            return message
    raise AssertionError("the stream ended")


@pytest.mark.bus
@pytest.mark.process
async def test_a_killed_navigator_stops_the_robot_and_the_next_goes_on(tmp_path):
    async with bus(clock="sim") as options, central(options):
        state = RobotState(World(load_floor("wean5"), seed=1), SimClock(1000.0), speed=6.0)
        async with (
            running(RobotModule(state, None, options).run()),
            Module("asker", options=options) as asker,
            asker.subscribe(Sensors) as sensed,
            asker.subscribe(Drive) as driven,
        ):
            async with navigate_process(options, tmp_path) as process:
                await asker.wait_for(NavigateToGoal, timeout=30)
                room = await asker.query(WhereIsRoom(room="r-5302"))
                goal = NavigateToGoal(x=room.x, y=room.y)
                drive = await asker.expand(goal, on_module_lost="resend", wait_for_handler=20)
                await until(sensed, lambda one: one.speed > 0.3)
                process.send_signal(signal.SIGKILL)
                await process.wait()
            stopped = await until(sensed, lambda one: abs(one.speed) < 0.01)
            last = max(drive.tick for drive in iter(driven.at_hand, None))
            assert 0 < stopped.tick - last <= SILENCE + 1 + BRAKING
            async with navigate_process(options, tmp_path):
                report = await drive.result(timeout=40)
                position = await asker.query(WhereAmI())
            truth = await asker.query(WhereReally())
    assert report.position.room == position.room == truth.room == "r-5302"
    assert truth.bumps == 0
