"""Kill -9 of modules, of central and of the router while a command runs."""

from __future__ import annotations

import asyncio
import signal
import sys
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import pytest
from central_robot import Arrive, Drive, Quick, Redrive, Where
from mortal_router import MortalRouter

from tca_bus import (
    BusOptions,
    Module,
    NoHandlerError,
    PeerLostError,
    TaskFailedError,
    TaskState,
)
from tca_bus._protocol import FindTask, ReadLog
from tca_bus.testing import bus, eventually

pytestmark = [pytest.mark.bus, pytest.mark.process]

ROBOT = str(Path(__file__).with_name("central_robot.py"))


class Processes:
    """Central and robots as processes of their own, all ended with the test."""

    def __init__(self, options: BusOptions, data: Path) -> None:
        self.options = options
        self.data = data
        self.running: list[asyncio.subprocess.Process] = []

    async def central(self):
        flags = ["--connect", self.options.connect, "--realm", self.options.realm]
        return await self.spawn("-m", "tca_bus", "central", "--data", str(self.data), *flags)

    async def robot(self):
        return await self.spawn(ROBOT, self.options.connect, self.options.realm)

    async def spawn(self, *arguments):
        process = await asyncio.create_subprocess_exec(sys.executable, *arguments)
        self.running.append(process)
        return process

    async def kill(self, process):
        process.send_signal(signal.SIGKILL)
        await process.wait()

    async def end(self):
        for process in self.running:
            if process.returncode is None:
                process.terminate()
        for process in self.running:
            await process.wait()


@asynccontextmanager
async def processes(options, data):
    running = Processes(options, data)
    try:
        yield running
    finally:
        await running.end()


@asynccontextmanager
async def office(data):
    """A bus, central and robot as processes, and a module that sends."""
    async with bus() as options, processes(options, data) as running:
        central, robot = await running.central(), await running.robot()
        async with Module("me", options=options) as me:
            await me.wait_for(Drive, "tca.submit", timeout=20.0)
            yield me, running, central, robot


async def until_active(me, handle):
    async def active():
        # A central that was just killed may still be asked.
        with suppress(PeerLostError, NoHandlerError):
            return (await me.query(FindTask(id=handle.id))).state is TaskState.ACTIVE

    await eventually(active, what="the command to run")


async def test_a_killed_module_fails_its_command(tmp_path):
    async with office(tmp_path) as (me, running, _, robot):
        handle = await me.execute(Drive(to="r-5303"))
        await until_active(me, handle)
        await running.kill(robot)
        with pytest.raises(TaskFailedError) as caught:
            await handle.result(timeout=10.0)
        assert caught.value.failure.name == "module_lost"
        assert caught.value.failure.module == "robot"


async def test_a_command_that_may_be_resent_goes_to_the_next_module(tmp_path):
    async with office(tmp_path) as (me, running, _, robot):
        handle = await me.execute(Redrive(to="r-5303"))
        await until_active(me, handle)
        await running.kill(robot)
        again = await running.robot()
        await eventually(lambda: handle.status.attempt == 2)
        await until_active(me, handle)
        await me.inform(Arrive())
        place = await handle.result(timeout=10.0)
        assert (place.pid, place.attempt) == (again.pid, 2)


async def test_central_goes_on_after_it_was_killed(tmp_path):
    async with office(tmp_path) as (me, running, central, robot):
        before = await me.execute(Quick(number=5), id="before")
        assert await before.result(timeout=10.0) == 5
        handle = await me.execute(Drive(to="r-5303"))
        queued = await me.execute(Quick(number=6))
        await until_active(me, handle)
        await running.kill(central)
        await me.inform(Arrive())
        await running.central()
        place = await handle.result(timeout=20.0)
        assert (place.pid, place.attempt) == (robot.pid, 1)
        assert await queued.result(timeout=10.0) == 6
        await me.wait_for(FindTask, ReadLog, timeout=10.0)
        assert (await me.query(FindTask(id="before"))).result == 5
        again = await me.execute(Quick(number=5), id="before")
        assert await again.result(timeout=10.0) == 5
        log = await me.query(ReadLog(task=handle.id))
        assert [line.event for line in log].count("submitted") == 1


async def test_a_command_goes_on_while_central_is_away(tmp_path):
    async with office(tmp_path) as (me, running, central, robot):
        handle = await me.execute(Drive(to="r-5303"))
        await until_active(me, handle)
        await running.kill(central)
        await running.central()
        await until_active(me, handle)
        assert await me.query(Where()) == "r-5303"
        await me.inform(Arrive())
        assert (await handle.result(timeout=10.0)).pid == robot.pid


async def test_a_module_that_died_with_central_is_seen_to_be_lost(tmp_path):
    async with office(tmp_path) as (me, running, central, robot):
        handle = await me.execute(Drive(to="r-5303"))
        await until_active(me, handle)
        await running.kill(central)
        await running.kill(robot)
        await running.central()
        with pytest.raises(TaskFailedError) as caught:
            await handle.result(timeout=20.0)
        assert caught.value.failure.name == "module_lost"


async def test_a_router_restart_is_not_the_death_of_all_modules(tmp_path):
    async with MortalRouter() as router, processes(router.options, tmp_path) as running:
        await running.central()
        robot = await running.robot()
        async with Module("me", options=router.options) as me:
            await me.wait_for(Drive, "tca.submit", timeout=20.0)
            handle = await me.execute(Drive(to="r-5303"))
            await until_active(me, handle)
            await router.die()
            await eventually(lambda: not me.is_connected)
            await router.rise()
            await me.connected()
            await me.wait_for(Drive, "tca.submit", timeout=20.0)
            quick = await me.execute(Quick(number=1), constraints=0, wait_for_handler=5.0)
            assert await quick.result(timeout=10.0) == 1
            await me.inform(Arrive())
            place = await handle.result(timeout=20.0)
            assert (place.pid, place.attempt) == (robot.pid, 1)


async def test_central_stops_cleanly_when_told_to(tmp_path):
    async with office(tmp_path) as (_, _, central, _):
        central.terminate()
        assert await central.wait() == 0
