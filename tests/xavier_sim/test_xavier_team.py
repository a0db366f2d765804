"""Several robots in one world, each on a realm of its own, in lockstep with all their drivers."""

from __future__ import annotations

import asyncio
import hashlib
from contextlib import asynccontextmanager

import pytest
from test_xavier_bus import StandIn, sim

from tca_bus import ConfigError, Module
from tca_bus.cli import BusFlags
from tca_bus.testing import bus, eventually
from xavier_sim.cli._recording import run_team_recorded
from xavier_sim.cli._run import run
from xavier_sim.cli._worlds import WorldFlags, open_team
from xavier_sim.floors import load_floor
from xavier_sim.messages import DoorMoved, Fault, MoveDoor, WheelSlip, WhereReally
from xavier_sim.recording import RecordingFileError, RecordingReader, retrace, ticks_of
from xavier_sim.running import SimClock, Team, make_fault, run_team
from xavier_sim.snapshots import SnapshotFile
from xavier_sim.world import RobotsError, World

PLAN = load_floor()
NAMES = ("xavier", "yoda")


def world_of_two(seed=1):
    return World(PLAN, seed, robots=NAMES)


@asynccontextmanager
async def team_of_two(options, *, speed=None, store=None):
    """Two robots, each on a realm of its own; the options of each are given, by its name."""
    team = Team(world_of_two(), SimClock(1000.0), speed=speed)
    own = {name: options.model_copy(update={"realm": name}) for name in NAMES}
    async with asyncio.TaskGroup() as group:
        running = group.create_task(run_team(team, store, own), name="team")
        try:
            yield team, own
        finally:
            running.cancel()


def driven_alike(ticks):
    """What both would sense if the commands of two stand-ins came straight to the world."""
    world, digests = world_of_two(), {name: hashlib.sha256() for name in NAMES}
    for tick in range(ticks):
        for name, robot in world.robots.items():
            digests[name].update(robot.reading.sonar.tobytes() + robot.reading.odom.tobytes())
        world.step_all(dict.fromkeys(NAMES, (0.3, 0.2 if tick % 7 == 0 else 0.0)))
    return {name: digest.hexdigest() for name, digest in digests.items()}


@pytest.mark.bus
async def test_lockstep_waits_for_the_drivers_of_all_robots():
    async with bus() as options, team_of_two(options) as (team, own):
        one, other = (StandIn(sim(own[name]), ticks=40) for name in NAMES)
        other.deaf = True
        async with other.module:
            await eventually(lambda: other.seen and not team._standings["yoda"].can)
            async with one.module:
                await eventually(lambda: other.seen and len(one.seen) > 2)
                assert team.world.tick == 0
                other.deaf = False
                await other.answer(other.seen[-1])
                await eventually(lambda: one.seen[-1].tick == other.seen[-1].tick == 40)
                for driver in (one, other):
                    assert len({sent.tick for sent in driver.seen}) == 41
    alike = driven_alike(41)
    assert [one.digest.hexdigest(), other.digest.hexdigest()] == [alike[name] for name in NAMES]


@pytest.mark.bus
async def test_one_that_nobody_drives_stands_while_the_other_goes_on():
    async with bus() as options, team_of_two(options) as (team, own):
        driver = StandIn(sim(own["yoda"]), ticks=30)
        async with driver.module:
            await eventually(lambda: team.world.tick >= 30)
    assert team.world.truth("yoda").metres > 0.4
    assert team.world.truth("xavier").metres == 0.0


@pytest.mark.bus
async def test_what_one_realm_does_to_a_door_the_other_hears_and_faults_are_of_one_robot():
    async with (
        bus() as options,
        team_of_two(options, speed=20.0) as (team, own),
        Module("asker", options=own["xavier"]) as asker,
        Module("other", options=own["yoda"]) as other,
        other.subscribe(DoorMoved) as moved,
    ):
        await asker.wait_for(MoveDoor, Fault, timeout=10)
        await other.wait_for(WhereReally, timeout=10)
        await asker.query(MoveDoor(room="r-5303", open=False))
        async with asyncio.timeout(10):
            news = await moved.get()
        assert (news.room, news.open) == ("r-5303", False)
        await other.query(Fault(fault=WheelSlip(share=0.3)))
        assert [robot.wheels.slip for robot in team.world.robots.values()] == [0.0, 0.3]
        places = [await one.query(WhereReally()) for one in (asker, other)]
        assert (places[0].x, places[0].y) != (places[1].x, places[1].y)


@pytest.mark.bus
async def test_a_change_from_any_realm_is_kept(tmp_path):
    store = SnapshotFile(tmp_path)
    async with (
        bus() as options,
        team_of_two(options, store=store) as (_, own),
        Module("other", options=own["yoda"]) as other,
    ):
        await other.wait_for(MoveDoor, timeout=10)
        await other.query(MoveDoor(room="r-5303", open=False))

        def door_is_kept():
            saved = store.load(floor=PLAN.name)
            return saved is not None and not saved.world["doors"]["d-5303"]

        await eventually(door_is_kept, timeout=10)
    flags = WorldFlags(robots="xavier,yoda", rays="numpy")
    team, _ = open_team(flags, speed="max", data=tmp_path, epoch=None)
    assert not team.world.doors()["r-5303"]
    assert {robot.now for robot in team.robots} == {team.robots[0].now}
    with pytest.raises(RobotsError, match="xavier, yoda, as in the snapshot"):
        open_team(
            WorldFlags(robots="xavier,han", rays="numpy"), speed="1", data=tmp_path, epoch=None
        )


@pytest.mark.bus
async def test_the_command_puts_each_robot_on_the_realm_of_its_name():
    async with bus() as options, asyncio.TaskGroup() as group:
        flags = BusFlags(connect=options.connect)
        running = group.create_task(
            run(speed="max", world=WorldFlags(robots="han, yoda", rays="numpy"), flags=flags),
            name="run",
        )
        for name in ("han", "yoda"):
            own = options.model_copy(update={"realm": name})
            async with Module("asker", options=own) as asker:
                await asker.wait_for(WhereReally, timeout=10)
                assert (await asker.query(WhereReally())).space == "foyer"
        running.cancel()


@pytest.mark.bus
async def test_each_robot_has_a_recording_of_its_own(tmp_path):
    async with bus() as options:
        own = {name: options.model_copy(update={"realm": name}) for name in NAMES}
        team = Team(world_of_two(), SimClock(1000.0), speed=50.0)
        async with asyncio.TaskGroup() as group:
            file = tmp_path / "drive.mcap"
            running = group.create_task(run_team_recorded(team, None, own, file))
            await eventually(lambda: team.world.tick >= 5)
            running.cancel()
    for name in NAMES:
        with RecordingReader(tmp_path / f"drive-{name}.mcap") as reader:
            ticks = list(ticks_of(reader, reader.path))
            assert reader.is_finished
            with pytest.raises(RecordingFileError, match="2 robots; it has the commands of one"):
                retrace(reader, make_fault=make_fault)
        # The one that is cancelled while it waits for the other has not sensed the last tick.
        assert len(ticks) >= team.world.tick
        assert [tick.sensors.tick for tick in ticks] == list(range(len(ticks)))
        truth = world_of_two().truth(name)
        assert (ticks[0].truth.x, ticks[0].truth.y) == (truth.x, truth.y)


@pytest.mark.parametrize("names", ["", "xavier,", "two words,yoda", "a/b"])
async def test_a_name_that_is_no_realm_is_refused(names):
    with pytest.raises(ConfigError, match="realm"):
        await run(world=WorldFlags(robots=names))


async def test_a_name_twice_is_refused():
    with pytest.raises(RobotsError, match="each once"):
        await run(world=WorldFlags(robots="yoda, yoda", rays="numpy"))
