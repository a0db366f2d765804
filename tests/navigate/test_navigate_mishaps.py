"""A navigator that fails by itself: the robot stands, the drive ends, and it goes on trying."""

from __future__ import annotations

import asyncio
import logging

import pytest
from navigate_office import running
from navigate_readings import reading

from navigate.driving import Wheels
from navigate.maps import Floor, load_plan
from navigate.messages import NavigateToGoal
from navigate.navigator import Navigator
from navigate.service import NavigateService, _helm
from navigate.service._intake import STILL
from tca_bus import Module, TaskFailedError
from tca_bus.testing import bus, central, eventually
from xavier_sim.messages import Drive


class Wire:
    """Takes what the helm says, and keeps the commands."""

    def __init__(self):
        self.commands = []

    def serve(self, *_):
        """Take any handler."""

    async def inform(self, command):
        """Take any command."""
        self.commands.append((command.tick, command.speed))

    def modules(self):
        """Name nobody."""
        return []


class Sender:
    """Where readings come from."""

    sender = "robot"


class Shaky(Navigator):
    """Drives on at each tick but those at which it fails."""

    def __init__(self, *fails_at):
        super().__init__(Floor(load_plan()))
        self.fails_at, self.given_up = fails_at, 0

    def step(self, sensors):
        if sensors.tick in self.fails_at:
            raise ZeroDivisionError(f"tick {sensors.tick}")
        self.wheels = Wheels(0.4, 0.0)
        return self.wheels

    def cancel(self):
        super().cancel()
        self.given_up += 1


async def nothing(_leapt):
    """Do nothing after a step."""


@pytest.mark.parametrize("lockstep", [False, True])
async def test_a_step_that_fails_is_answered_by_a_stop_and_the_next_is_tried(lockstep, caplog):
    wire, navigator, failed = Wire(), Shaky(2, 3), []
    helm = _helm.Helm(navigator, wire, nothing, failed.append)
    for tick in (1, 2, 2, 3, 4):
        await helm._on_sensors(reading(tick, lockstep=lockstep), Sender)
    assert wire.commands == [(1, 0.4), (2, 0.0), (2, 0.0), (3, 0.0), (4, 0.4)]
    assert [str(error) for error in failed] == ["tick 2", "tick 3"]
    assert navigator.given_up == 2
    (said,) = caplog.records
    assert said.getMessage() == "the navigator failed at tick 2 and stands"
    assert said.exc_info[0] is ZeroDivisionError


@pytest.mark.parametrize(("lockstep", "stops"), [(False, True), (True, False)])
async def test_a_robot_whose_clock_hangs_is_not_driven_on_unless_it_waits(lockstep, stops):
    wire = Wire()
    helm = _helm.Helm(Shaky(), wire, nothing, [].append)
    for _ in range(STILL + 2):
        await helm._on_sensors(reading(1, lockstep=lockstep), Sender)
    speeds = [speed for _, speed in wire.commands]
    assert speeds == [0.4] * STILL + [0.0 if stops else 0.4] * 2
    await helm._on_sensors(reading(2, lockstep=lockstep), Sender)
    assert wire.commands[-1] == (2, 0.4)


@pytest.mark.bus
async def test_a_drive_in_which_the_navigator_fails_ends_so_and_the_next_begins(
    monkeypatch, caplog
):
    answers = asyncio.Queue()

    async def take(drive, _context):
        answers.put_nowait(drive)

    navigator = Navigator(Floor(load_plan()))
    goal = NavigateToGoal(x=2187.0, y=7000.0)
    async with bus() as options, central(options):
        service, robot = NavigateService(navigator, options), Module("robot", options=options)
        robot.serve(Drive, take)
        async with robot, running(service.run()):
            await robot.wait_for(NavigateToGoal, timeout=10)
            await service.module.wait_for(Drive, timeout=10)
            await robot.broadcast(reading(1))
            handle = await robot.expand(goal, wait_for_handler=10)
            await eventually(lambda: navigator.busy)
            with monkeypatch.context() as broken, caplog.at_level(logging.ERROR):
                broken.setattr(navigator.localizer, "sense", lambda *_, **__: 1 / 0)
                await robot.broadcast(reading(2))
                with pytest.raises(TaskFailedError, match="ZeroDivisionError") as caught:
                    await handle.result(timeout=20)
            again = await robot.expand(goal)
            await eventually(lambda: navigator.busy)
            await robot.broadcast(reading(3))
            async with asyncio.timeout(10):
                while (told := await answers.get()).tick < 3:
                    assert told.tick < 2 or told.speed == told.turn_rate == 0.0
            assert told.busy
            await again.kill("enough")
    assert caught.value.failure.name == "handler_error"
    assert caught.value.failure.text.startswith("did not get to r-5432: the navigator failed,")
    assert [bool(one.exc_info) for one in caplog.records] == [True]
