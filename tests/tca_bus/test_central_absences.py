"""A module that is out of reach is not dead yet: its tasks wait as long as central is told to."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest
from mortal_router import MortalRouter

from tca_bus import (
    Command,
    ConfigError,
    Module,
    NoHandlerError,
    TaskFailedError,
)
from tca_bus._central import Central
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


class Lift(Command[str]):
    pass


class Relift(Command[str]):
    on_module_lost = "resend"


class Lifter:
    """Lifts until told that it is up."""

    def __init__(self, name, options):
        self.name = name
        self.module = Module(name, options=options)
        self.begun: list[int] = []
        self.stopped: list[int] = []
        self.up = asyncio.Event()
        self.module.serve(Lift, self.lift)
        self.module.serve(Relift, self.lift)

    async def lift(self, message, context):
        self.begun.append(context.attempt)
        try:
            await self.up.wait()
        except asyncio.CancelledError:
            self.stopped.append(context.attempt)
            raise
        return self.name


class FarSide:
    """A router that can be away, linked to the one of central, and a lifter there."""

    def __init__(self, near):
        self._router = MortalRouter(linked_to=(near.connect,), realm=near.realm)
        self.cut, self.heal = self._router.die, self._router.rise

    async def __aenter__(self):
        await self._router.__aenter__()
        self.lifter = Lifter("far", self._router.options)
        await self.lifter.module.__aenter__()
        return self

    async def __aexit__(self, *reason):
        await self.lifter.module.__aexit__(*reason)
        await self._router.__aexit__(*reason)


@asynccontextmanager
async def two_sides(*, lost_after):
    async with (
        bus() as near,
        Central(near, lost_after=lost_after) as running,
        FarSide(near) as far,
        Module("boss", options=near) as boss,
    ):
        await boss.wait_for(Lift, Relift, timeout=10.0)
        yield near, far, boss, running


def sees(boss, name):
    return any(module.name == name for module in boss.modules())


def has_handler(running, message):
    """Whether central, which need not see what others see, would give such a task to a module."""
    return bool(running.tree.pools.provides(message.wire_name))


async def test_a_task_goes_on_when_its_module_is_back_in_time():
    async with two_sides(lost_after=60.0) as (_, far, boss, running):
        handle = await boss.execute(Lift())
        await eventually(lambda: far.lifter.begun)
        await far.cut()
        await eventually(lambda: not has_handler(running, Lift))
        with pytest.raises(NoHandlerError):
            await boss.execute(Lift())
        far.lifter.up.set()
        await far.heal()
        assert await handle.result(timeout=20.0) == "far"
        assert far.lifter.begun == [1]


async def test_a_task_that_was_given_to_another_is_stopped_where_it_was():
    async with two_sides(lost_after=0.0) as (near, far, boss, _):
        handle = await boss.execute(Relift())
        await eventually(lambda: far.lifter.begun)
        spare = Lifter("spare", near)
        async with spare.module:
            await far.cut()
            await eventually(lambda: spare.begun == [2])
            await far.heal()
            await eventually(lambda: far.lifter.stopped == [1])
            spare.up.set()
            assert await handle.result(timeout=10.0) == "spare"
        assert spare.stopped == []


async def test_the_next_start_of_a_module_ends_the_wait_for_the_one_before():
    async with bus() as options, central(options, lost_after=1e6):
        async with Module("boss", options=options) as boss:
            first = Lifter("lifter", options)
            async with first.module:
                await boss.wait_for(Lift, timeout=10.0)
                handle = await boss.execute(Lift())
                await eventually(lambda: first.begun)
                first.up.clear()
            await eventually(lambda: not sees(boss, "lifter"))
            assert not handle.status.is_ended
            async with Lifter("lifter", options).module:
                with pytest.raises(TaskFailedError) as caught:
                    await handle.result(timeout=10.0)
        assert caught.value.failure.name == "module_lost"


async def test_central_ends_cleanly_while_a_module_comes_and_it_waits_for_another():
    async with bus() as options:
        async with Central(options, lost_after=1e6) as running:
            async with Lifter("lifter", options).module:
                await eventually(lambda: has_handler(running, Lift))
            await eventually(running._absences.awaited)
            # Who waits is woken, and cancelled before it runs.
            running._absences.presence_changed()
        assert running.module.is_closed


@pytest.mark.parametrize("seconds", [-1.0, float("inf"), float("nan")])
def test_a_patience_that_is_no_time_is_refused(seconds):
    with pytest.raises(ConfigError, match="--lost-after"):
        Central(lost_after=seconds)
