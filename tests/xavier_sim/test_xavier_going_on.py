"""A robot that was stopped and is started again: it goes on as if there had been no break."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading

import pytest

from tca_bus import Module
from tca_bus.testing import bus, eventually
from xavier_sim.cli._recording import run_recorded
from xavier_sim.cli._worlds import WorldFlags, open_team, open_world
from xavier_sim.messages import Drive, Sensors
from xavier_sim.recording import RecordingReader, retrace, ticks_of
from xavier_sim.running import Reflex, RobotModule, make_fault, run_team
from xavier_sim.snapshots import SnapshotFile

EPOCH = "1997-06-02T09:00+00:00"
WORLD = WorldFlags(seed=5, profile="hard", people_walking=4, rays="numpy")


def opened(data, world=WORLD):
    return open_world(world, speed="max", data=data, epoch=EPOCH)


def wheels(tick):
    return 0.6, 0.5 * (-1) ** (tick // 12)


async def answer(driver, sensors):
    speed, turn = wheels(sensors.tick)
    await driver.inform(Drive(tick=sensors.tick, speed=speed, turn_rate=turn, busy=True))


async def drive_on(options, data, file, ticks):
    """Drive until so many ticks, however far beyond it comes, and stop; gives the last tick."""
    state, store = opened(data)
    async with Module("navigate", options=options) as driver:

        @driver.handler(Sensors)
        async def drive(sensors, context):
            await answer(driver, sensors)

        robot = asyncio.create_task(run_recorded(state, store, options, file), name="robot")
        await eventually(lambda: state.tick >= ticks)
        robot.cancel()
        await asyncio.gather(robot, return_exceptions=True)
    return state.tick


def recorded(*files):
    """What was sensed and what the wheels took at each tick, and the first tick of each file."""
    sensed, driven, firsts = {}, {}, []
    for file in files:
        with RecordingReader(file) as reader:
            ticks = list(ticks_of(reader, file))
        firsts.append(ticks[0].sensors.tick)
        for one in ticks:
            said = one.sensors.model_dump_json()
            assert sensed.setdefault(one.sensors.tick, said) == said
            if one.command is not None:
                driven[one.sensors.tick] = one.command
    return sensed, driven, firsts


@pytest.mark.bus
async def test_a_robot_that_was_stopped_twice_senses_what_one_does_that_was_not(tmp_path):
    parts = [tmp_path / f"part-{number}.mcap" for number in range(3)]
    whole, data = tmp_path / "whole.mcap", tmp_path / "data"
    async with bus() as options:
        await drive_on(options, None, whole, 100)
        ends = [await drive_on(options, data, file, 33 * (n + 1)) for n, file in enumerate(parts)]
    sensed, driven, firsts = recorded(*parts)
    assert firsts == [0, *ends[:-1]]
    expected = recorded(whole)
    common = [tick for tick in expected[0] if tick in sensed]
    assert len(common) > 95
    assert [sensed[tick] for tick in common] == [expected[0][tick] for tick in common]
    common = [tick for tick in expected[1] if tick in driven]
    assert [driven[tick] for tick in common] == [expected[1][tick] for tick in common]
    assert any(driven[tick].speed < wheels(tick)[0] for tick in common), "the reflex never held"
    for file in parts:
        with RecordingReader(file) as reader:
            assert retrace(reader, make_fault=make_fault, rays="numpy") > 1


@pytest.mark.parametrize("stopped", [False, True])
async def test_what_is_kept_at_a_stop_is_all_that_there_is(tmp_path, stopped):
    state, store = opened(tmp_path)
    reflex = Reflex()
    state.attach(reflex)
    for tick in range(37):
        await state.advance(*wheels(tick))
    store.save(state.saved(stopped=stopped))
    again, _ = opened(tmp_path)
    other = Reflex()
    again.attach(other)
    assert other.snapshot() == reflex.snapshot()
    assert again.tick == (37 if stopped else state.saved().tick_limit + 1)
    assert (again.now == state.now) == stopped
    if stopped:
        assert again.sensors().model_dump_json() == state.sensors().model_dump_json()
        assert [again.robot.look(37) for _ in range(9)] == [state.robot.look(37) for _ in range(9)]
    assert again.must_save


async def test_a_snapshot_from_before_there_were_reflexes_in_it_is_gone_on_with(tmp_path):
    state, store = opened(tmp_path)
    store.save(state.saved())
    kept = json.loads(store.path.read_text())
    del kept["reflexes"], kept["stopped"]
    store.path.write_text(json.dumps(kept))
    again, _ = opened(tmp_path)
    reflex, fresh = Reflex(), Reflex()
    again.attach(reflex)
    fresh.sense(again.reading)
    assert reflex.snapshot() == fresh.snapshot()


@pytest.mark.bus
async def test_a_team_that_was_stopped_goes_on_at_its_tick_with_all_reflexes(tmp_path):
    names = ("xavier", "yoda")
    flags = WorldFlags(robots=",".join(names), rays="numpy")
    team, store = open_team(flags, speed="40", data=tmp_path, epoch=EPOCH)
    async with bus() as options, asyncio.TaskGroup() as group:
        own = {name: options.model_copy(update={"realm": name}) for name in names}
        running = group.create_task(run_team(team, store, own), name="team")
        await eventually(lambda: team.world.tick > 12)
        running.cancel()
    again, _ = open_team(flags, speed="40", data=tmp_path, epoch=EPOCH)
    assert again.world.snapshot() == team.world.snapshot()
    for robot, before in zip(again.robots, team.robots, strict=True):
        reflex = Reflex()
        robot.attach(reflex)
        assert reflex.snapshot() == before.reflex.snapshot()


class SlowStore(SnapshotFile):
    """Its first save takes until it is let go."""

    def __init__(self, folder):
        super().__init__(folder)
        self.saved, self.go = [], threading.Event()

    def save(self, saved):
        if not self.saved:
            self.saved.append(saved)
            self.go.wait(20)
        else:
            self.saved.append(saved)
        super().save(saved)


@pytest.mark.bus
async def test_a_stop_during_a_save_is_what_is_kept(tmp_path):
    state, _ = opened(None)
    store = SlowStore(tmp_path)
    async with bus() as options:
        robot = asyncio.create_task(RobotModule(state, store, options).run(), name="robot")
        await eventually(lambda: store.saved)
        robot.cancel()
        asyncio.get_running_loop().call_later(0.1, store.go.set)
        await asyncio.gather(robot, return_exceptions=True)
    assert [saved.stopped for saved in store.saved] == [False, True]
    assert store.load(floor="wean5").stopped


@pytest.mark.process
async def test_a_process_that_was_told_to_end_goes_on_where_it_was(tmp_path):
    files = [tmp_path / f"part-{number}.mcap" for number in range(2)]
    async with bus() as options, Module("navigate", options=options) as driver:
        ticks = []

        @driver.handler(Sensors)
        async def drive(sensors, context):
            ticks.append(sensors.tick)
            await answer(driver, sensors)

        for file in files:
            robot = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "xavier_sim", "run", "--speed", "max", "--seed", "3"),
                *("--data", str(tmp_path), "--record", str(file)),
                *("--connect", options.connect, "--realm", options.realm),
            )
            begun = len(ticks)
            try:
                await eventually(lambda begun=begun: len(ticks) > begun + 30, timeout=20)
            finally:
                robot.send_signal(signal.SIGTERM)
                assert await robot.wait() == 0
    sensed, _, firsts = recorded(*files)
    assert list(sensed) == list(range(len(sensed)))
    assert firsts[1] > 20
    done = await asyncio.to_thread(
        subprocess.run,
        [sys.executable, "-m", "xavier_sim", "verify", str(files[1]), "--json", "--rays", "numpy"],
        env={**os.environ, "PYTHONHASHSEED": "7"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["complete"]
