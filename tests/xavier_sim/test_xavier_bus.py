"""The robot on a real bus, with a stand-in driver of a few lines."""

from __future__ import annotations

import asyncio
import hashlib
import logging
import math
from contextlib import asynccontextmanager

import pytest
from mortal_router import MortalRouter

from tca_bus import HandlerFailedError, Module
from tca_bus.testing import bus, eventually
from xavier_sim.floors import load_floor
from xavier_sim.messages import (
    CameraPower,
    Drive,
    Fault,
    MoveDoor,
    Sensors,
    WhereReally,
    WorldDoors,
)
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.snapshots import SnapshotFile
from xavier_sim.world import World

pytestmark = pytest.mark.bus

PLAN = load_floor()
EPOCH = 1000.0


@asynccontextmanager
async def robot(options, *, speed=None, store=None, saved=None, world=None, witness=None):
    state = RobotState(world or World(PLAN, seed=1), SimClock(EPOCH), speed=speed)
    if saved is not None:
        state.restore(saved, at_least=0.0)
    async with asyncio.TaskGroup() as group:
        running = group.create_task(RobotModule(state, store, options, witness).run(), name="robot")
        try:
            yield state
        finally:
            running.cancel()


class StandIn:
    """Drives ahead, with a turn now and then, for as many ticks as it is told."""

    def __init__(self, options, *, name="navigate", ticks=0):
        self.module = Module(name, options=options)
        self.module.serve(Sensors, self.on_sensors)
        self.ticks, self.seen, self.deaf = ticks, [], False
        self.digest = hashlib.sha256()

    async def on_sensors(self, sensors, context):
        new = not self.seen or sensors.tick != self.seen[-1].tick
        if new:
            self.digest.update(sensors.sonar.tobytes() + sensors.odom.tobytes())
        self.seen.append(sensors)
        if not self.deaf:
            await self.answer(sensors)

    async def answer(self, sensors):
        busy = sensors.tick < self.ticks
        turn = 0.2 if sensors.tick % 7 == 0 else 0.0
        drive = Drive(tick=sensors.tick, speed=0.3 * busy, turn_rate=turn * busy, busy=busy)
        await self.module.inform(drive)


def sim(options):
    return options.model_copy(update={"clock": "sim"})


async def test_lockstep_waits_for_the_driver_tick_by_tick():
    async with bus() as options, robot(options) as state:
        driver = StandIn(options, ticks=50)
        async with driver.module:
            await eventually(lambda: driver.seen and driver.seen[-1].tick == 50)
            ticks = [sensors.tick for sensors in driver.seen]
            assert sorted(set(ticks)) == list(range(51))
            assert all(sensors.lockstep for sensors in driver.seen)
            assert state.now == pytest.approx(EPOCH + 5.0)


async def test_lockstep_outcome_does_not_depend_on_load():
    digests = set()
    for pause in (0.0, 0.003):
        async with bus() as options, robot(options) as state:
            driver = StandIn(options, ticks=60)
            answer = driver.answer

            async def slow_answer(sensors, answer=answer, pause=pause):
                await asyncio.sleep(pause)
                await answer(sensors)

            driver.answer = slow_answer
            async with driver.module:
                await eventually(lambda state=state: state.world.tick == 60)
                await eventually(lambda driver=driver: driver.seen[-1].tick == 60)
                digests.add(driver.digest.hexdigest())
    assert len(digests) == 1


class Diary:
    """Writes down what the robot tells its witness."""

    def __init__(self):
        self.pages = []

    async def sense(self, sensors, truth, standing):
        assert truth.tick == sensors.tick
        self.pages.append(("sensed", sensors.tick))

    def note(self, message, time):
        self.pages.append((type(message).__name__, round((time - EPOCH) * 10)))


async def test_a_witness_is_told_each_tick_once_and_what_was_done_in_it():
    diary = Diary()
    async with bus() as options, robot(options, witness=diary) as state:
        driver = StandIn(options, ticks=3)
        async with driver.module:
            await eventually(lambda: state.world.tick == 3 and driver.seen[-1].tick == 3)
            await driver.module.query(MoveDoor(room="r-5309", open=False))
            fault = Fault(fault=CameraPower(on=False))
            await driver.module.query(fault)
    told = [page for page in diary.pages if page[0] != "Battery"]
    ticks = [(what, tick) for tick in range(3) for what in ("sensed", "Drive")]
    assert told == [*ticks, ("sensed", 3), ("DoorMoved", 3), ("Fault", 3)]


async def test_lost_sensors_are_sent_again():
    async with bus() as options, robot(options) as state:
        driver = StandIn(options, ticks=5)
        driver.deaf = True
        async with driver.module:
            await eventually(lambda: len(driver.seen) >= 3)
            assert state.world.tick == 0
            driver.deaf = False
            await eventually(lambda: state.world.tick == 5)


async def test_time_stands_still_without_a_driver_and_moves_for_who_waits():
    async with bus() as options, robot(options) as state:
        async with Module("waiter", options=sim(options)) as waiter:
            await waiter.clock.wait_ready(10)
            assert waiter.clock.now() == EPOCH
            await waiter.clock.sleep(3.0)
            assert waiter.clock.now() == pytest.approx(EPOCH + 3.0)
            assert state.now == pytest.approx(EPOCH + 3.0)
        assert state.world.truth().metres == 0.0


async def test_time_moves_through_an_idle_driver_for_who_waits():
    async with bus() as options, robot(options) as state:
        driver = StandIn(options)
        async with driver.module, Module("waiter", options=sim(options)) as waiter:
            await waiter.clock.wait_ready(10)
            await eventually(lambda: driver.seen)
            await waiter.clock.sleep(4.0)
            assert state.now == pytest.approx(EPOCH + 4.0)
            answered = {sensors.tick for sensors in driver.seen}
            assert answered >= set(range(40))


async def test_who_waits_longer_does_not_rob_who_was_woken():
    """The first to be woken waits again before time goes on for the other."""
    async with (
        bus() as options,
        robot(options),
        Module("long", options=sim(options)) as long,
        Module("short", options=sim(options)) as short,
    ):
        await asyncio.gather(long.clock.wait_ready(10), short.clock.wait_ready(10))
        patient = asyncio.create_task(long.clock.sleep(20.0), name="patient")
        begun = short.clock.now()
        for number in range(1, 6):
            await short.clock.sleep_until(begun + number)
            assert short.clock.now() == pytest.approx(begun + number, abs=0.11)
        await patient


async def test_who_waits_passively_acts_at_exactly_its_time_while_the_robot_drives():
    ticks = []
    async with (
        bus() as options,
        robot(options) as state,
        Module("poster", options=sim(options)) as poster,
    ):
        await poster.clock.wait_ready(10)
        driver = StandIn(options, ticks=60)

        async def post():
            for when in (1.0, 2.0, 2.05, 4.0):
                async with poster.clock.at(EPOCH + when):
                    begun = (await poster.query(WhereReally())).tick
                    for _ in range(3):
                        assert (await poster.query(WhereReally())).tick == begun
                    ticks.append((begun, max(sensors.tick for sensors in driver.seen)))

        posting = asyncio.create_task(post(), name="post")
        async with driver.module:
            await eventually(lambda: state.world.tick == 60)
        await posting
    assert ticks == [(10, 10), (20, 20), (21, 21), (40, 40)]


async def test_who_waits_passively_does_not_make_time_move():
    async with (
        bus() as options,
        robot(options) as state,
        Module("poster", options=sim(options)) as poster,
        Module("sleeper", options=sim(options)) as sleeper,
    ):
        await asyncio.gather(poster.clock.wait_ready(10), sleeper.clock.wait_ready(10))
        deadline = asyncio.create_task(poster.clock.watch_until(EPOCH + 3.0))
        await sleeper.clock.sleep(2.0)
        assert not deadline.done()
        assert state.now == pytest.approx(EPOCH + 2.0)
        await sleeper.clock.sleep(2.0)
        await deadline


async def test_who_dies_while_time_stands_still_for_it_holds_up_nobody(monkeypatch):
    for patience in ("HOLD_LIMIT", "FORGET_AFTER"):
        monkeypatch.setattr(f"xavier_sim.running._simulated_time.{patience}", 1e9)
    async with bus() as options, robot(options), Module("other", options=sim(options)) as other:
        await other.clock.wait_ready(10)
        async with Module("victim", options=sim(options)) as victim:
            await victim.clock.wait_ready(10)
            holding = asyncio.create_task(hold_for_ever(victim.clock), name="hold")
            await asyncio.sleep(0)
            # Answered after the robot has heard of it: both go the same way.
            await victim.query(WhereReally())
        begun = other.clock.now()
        async with asyncio.timeout(30):
            await other.clock.sleep(1.0)
        assert other.clock.now() == pytest.approx(begun + 1.0)
        holding.cancel()


async def hold_for_ever(clock):
    with clock.hold():
        await asyncio.Event().wait()


async def test_who_hangs_while_time_stands_still_for_it_is_named(monkeypatch, caplog):
    monkeypatch.setattr("xavier_sim.running._simulated_time.HOLD_LIMIT", 0.2)
    async with (
        bus() as options,
        robot(options),
        Module("victim", options=sim(options)) as victim,
        Module("other", options=sim(options)) as other,
    ):
        await asyncio.gather(victim.clock.wait_ready(10), other.clock.wait_ready(10))
        holding = asyncio.create_task(hold_for_ever(victim.clock), name="hold")
        await asyncio.sleep(0)
        await other.clock.sleep(1.0)
        holding.cancel()
    assert "simulated time stood still for module victim" in caplog.text


async def test_killed_driver_stops_the_robot_until_another_comes():
    async with bus() as options, robot(options) as state:
        async with StandIn(options, ticks=10_000).module:
            await eventually(lambda: state.world.tick > 30)
        tick = state.world.tick
        async with StandIn(options, ticks=tick + 40).module:
            await eventually(lambda: state.world.tick >= tick + 40)


async def test_lost_router_stops_time_until_it_is_back():
    async with MortalRouter() as router, robot(router.options) as state:
        driver = StandIn(router.options, ticks=100_000)
        async with driver.module:
            await eventually(lambda: state.world.tick > 30)
            await router.die()
            await eventually(lambda: not driver.module.is_connected)
            tick = state.world.tick
            await router.rise()
            await eventually(lambda: state.world.tick > tick + 30)
            assert {sensors.tick for sensors in driver.seen} >= set(range(tick + 29))


async def test_paced_world_moves_by_itself_and_stops_without_a_driver():
    async with bus() as options, robot(options, speed=20.0) as state:
        driver = StandIn(options, name="other", ticks=1_000_000)
        async with driver.module:
            await eventually(lambda: state.world.truth().metres > 0.3)
            assert not driver.seen[-1].lockstep
        await eventually(lambda: state.world.reading.speed == 0.0)
        tick = state.world.tick
        await eventually(lambda: state.world.tick > tick + 5)


@pytest.mark.parametrize("speed", [math.nan, math.inf, 99.0])
async def test_a_driver_that_sends_absurd_speeds_stops_a_moving_robot_and_is_told_of(speed, caplog):
    async with bus() as options, robot(options, speed=20.0) as state:
        driver = StandIn(options, ticks=1_000_000)
        async with driver.module:
            await eventually(lambda: state.world.truth().metres > 0.3)

            async def absurd(sensors):
                wrong = {"speed": speed, "turn_rate": 0.0, "busy": True}
                await driver.module.inform(Drive.model_construct(tick=sensors.tick, **wrong))

            driver.answer = absurd
            await eventually(lambda: state.world.reading.speed == 0.0)
            await eventually(lambda: "xavierDrive" in caplog.text and "speed" in caplog.text)


async def test_a_driver_that_jumps_ahead_or_back_in_time_is_not_heard():
    async with bus() as options, robot(options, speed=20.0) as state:
        driver = StandIn(options, ticks=1_000_000)

        async def jump(sensors):
            for tick in (sensors.tick + 10_000, 0):
                await driver.module.inform(Drive(tick=tick, speed=0.5, turn_rate=0.0, busy=True))

        async with driver.module:
            await eventually(lambda: state.world.truth().metres > 0.3)
            driver.answer = jump
            await eventually(lambda: state.world.reading.speed == 0.0)


async def test_doors_and_truth():
    async with bus() as options, robot(options), Module("asker", options=options) as asker:
        await asker.wait_for(WhereReally, MoveDoor, WorldDoors, timeout=10)
        assert (await asker.query(WhereReally())).space == "foyer"
        assert not (await asker.query(MoveDoor(room="r-5313", open=False))).open
        states = {door.room: door.open for door in await asker.query(WorldDoors())}
        assert len(states) == 60
        assert [room for room, is_open in states.items() if not is_open] == ["r-5313"]
        with pytest.raises(HandlerFailedError) as caught:
            await asker.query(MoveDoor(room="r5313", open=False))
        assert caught.value.failure.name == "unknown_room"
        assert "r-5313" in caught.value.failure.text


async def test_door_is_on_disk_soon_and_the_world_at_the_end(tmp_path):
    store = SnapshotFile(tmp_path)
    async with bus() as options:
        async with robot(options, store=store), Module("asker", options=options) as asker:
            await asker.wait_for(MoveDoor, timeout=10)
            await asker.query(MoveDoor(room="r-5313", open=False))
            await eventually(lambda: is_shut(store))
            driver = StandIn(options, ticks=12)
            async with driver.module:
                await eventually(lambda: driver.seen and driver.seen[-1].tick == 12)
        saved = store.load(floor=PLAN.name)
        assert saved.world["tick"] == 12
        async with robot(options, saved=saved) as state:
            assert (state.tick, state.now) == (12, EPOCH + 1.2)
            assert not state.world.doors()["r-5313"]


def is_shut(store):
    saved = store.load(floor=PLAN.name)
    return saved is not None and not saved.world["doors"]["d-5313"]


@pytest.mark.parametrize("speed", [math.nan, math.inf, -math.inf, 100.0, "fast"])
async def test_an_absurd_command_moves_nothing_and_is_told_once(speed, caplog):
    async with (
        bus() as options,
        robot(options, speed=20.0) as state,
        Module("navigate", options=options) as driver,
    ):
        await driver.wait_for(Drive, timeout=10)
        with caplog.at_level(logging.WARNING):
            for tick in range(3):
                fields = {"tick": tick, "speed": speed, "turn_rate": 0.0, "busy": True}
                await driver.inform_json("xavierDrive", fields)
            begun = state.world.tick
            await eventually(lambda: state.world.tick > begun + 10)
        assert state.world.truth().metres == 0.0
    words = [text for text in caplog.messages if "xavierDrive" in text]
    assert len(words) == 1
    assert "speed: " in words[0]
