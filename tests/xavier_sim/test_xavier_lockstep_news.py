"""What is told in lockstep is taken before the next tick, whoever has to take it."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest

from tca_bus import Module
from tca_bus.testing import bus, eventually
from xavier_sim.floors import load_floor
from xavier_sim.messages import DoorMoved, Drive, MoveDoor, Sensors, WhereReally
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.world import World

pytestmark = pytest.mark.bus

MOVES = 10


@asynccontextmanager
async def driving(options):
    """A robot that drives and drives, in lockstep."""
    state = RobotState(World(load_floor(), seed=1), SimClock(1000.0), speed=None)
    driver = Module("navigate", options=options)

    @driver.handler(Sensors)
    async def answer(sensors, context):
        await driver.inform(Drive(tick=sensors.tick, speed=0.0, turn_rate=0.3, busy=True))

    async with asyncio.TaskGroup() as group:
        running = group.create_task(RobotModule(state, None, options).run(), name="robot")
        async with driver:
            await driver.clock.wait_ready(10.0)
            yield
        running.cancel()


async def test_who_hears_of_a_door_can_act_at_the_very_tick():
    heard = []
    async with bus(clock="sim") as options:
        listener = Module("listener", options=options)

        @listener.handler(DoorMoved)
        async def on_door(moved, context):
            now = listener.clock.now()
            # As one does who is woken by one who is woken.
            for _ in range(5):
                await asyncio.sleep(0)
            with listener.clock.hold():
                truth = await listener.query(WhereReally())
                heard.append((moved.time, now, truth.time))

        async with listener, driving(options), Module("asker", options=options) as asker:
            await asker.wait_for(MoveDoor, timeout=10.0)
            await listener.clock.wait_ready(10.0)
            for number in range(MOVES):
                await asker.query(MoveDoor(room="r-5309", open=bool(number % 2)))
                await eventually(lambda number=number: len(heard) > number)
    assert heard == [(time, time, time) for time, _, _ in heard]
    assert len({time for time, _, _ in heard}) > 1


async def test_time_stands_still_for_a_block_from_its_first_line_on():
    seen = []
    async with (
        bus(clock="sim") as options,
        driving(options),
        Module("asker", options=options) as asker,
    ):
        await asker.wait_for(WhereReally, timeout=10.0)
        await asker.clock.wait_ready(10.0)
        for _ in range(MOVES):
            with asker.clock.hold():
                before = await asker.query(WhereReally())
                seen.append((before.tick, (await asker.query(WhereReally())).tick))
            await asker.clock.sleep(0.3)
    assert all(before == after for before, after in seen)
    assert len(set(seen)) == MOVES
