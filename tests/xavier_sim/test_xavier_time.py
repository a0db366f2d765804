"""Simulated time: demands, announcements, lockstep, pacing, and going on after a restart."""

from __future__ import annotations

import itertools

import pytest

from tca_bus import AwaitTime, ConfigError
from xavier_sim.cli._worlds import WorldFlags, open_world
from xavier_sim.floors import load_floor
from xavier_sim.messages import Drive
from xavier_sim.running import RobotState, SimClock, parse_speed
from xavier_sim.running._driver import SILENCE, STOP, Driver
from xavier_sim.running._pacing import Metronome, may_tick
from xavier_sim.running._simulated_time import (
    ABSENT_AFTER,
    FORGET_AFTER,
    HOLD_LIMIT,
    NEWS_MOVING,
    NEWS_STILL,
    Demands,
    TimeNews,
)
from xavier_sim.snapshots import SnapshotError, SnapshotFile
from xavier_sim.world import World

PLAN = load_floor()


def here(_incarnation):
    return True


def wait(name, until, *, moves=True):
    return AwaitTime(module=name, incarnation=name, until=until, moves=moves)


def test_demand_makes_time_move_until_it_comes():
    demands = Demands()
    assert not demands.note(wait("a", 10.0), now=5.0, wall=0.0)
    assert demands.moving
    assert not demands.reached(9.9, wall=0.1)
    assert demands.reached(10.0, wall=0.2)
    assert not demands.moving
    assert demands.holding


def test_passive_demand_stops_time_but_does_not_move_it():
    demands = Demands()
    demands.note(wait("watcher", 10.0, moves=False), now=5.0, wall=0.0)
    assert not demands.moving
    demands.note(wait("sleeper", 20.0), now=5.0, wall=0.0)
    assert demands.reached(10.0, wall=0.2)
    assert demands.holding
    demands.note(wait("watcher", None), now=10.0, wall=0.3)
    assert not demands.holding
    assert demands.moving


def test_woken_module_releases_time_by_its_next_word():
    demands = Demands()
    demands.note(wait("a", 10.0), now=5.0, wall=0.0)
    demands.note(wait("b", 20.0), now=5.0, wall=0.0)
    demands.reached(10.0, wall=0.2)
    assert demands.moving
    demands.note(wait("a", None), now=10.0, wall=0.25)
    assert not demands.holding
    assert demands.moving


@pytest.mark.parametrize("until", [5.0, 4.0])
def test_demand_for_now_holds_time_until_it_is_taken_back(until):
    demands = Demands()
    assert demands.note(wait("a", until, moves=False), now=5.0, wall=0.0)
    assert demands.holding
    assert demands.note(wait("a", until, moves=False), now=5.0, wall=1.0)
    assert demands.holding
    demands.note(wait("a", 6.0), now=5.0, wall=1.1)
    assert not demands.holding


def test_module_holds_time_up_only_so_long_however_often_it_says_so():
    demands = Demands()
    demands.note(wait("a", 10.0), now=5.0, wall=0.0)
    demands.reached(10.0, wall=0.2)
    assert demands.clean(0.2 + HOLD_LIMIT - 1.0, here) == []
    demands.note(wait("a", 10.0, moves=False), now=10.0, wall=HOLD_LIMIT)
    assert demands.clean(0.2 + HOLD_LIMIT + 0.01, here) == ["a"]
    assert not demands.holding
    demands.note(wait("a", 10.0, moves=False), now=10.0, wall=HOLD_LIMIT + 1.0)
    assert not demands.holding
    assert demands.clean(HOLD_LIMIT + 2.0, here) == []
    demands.note(wait("a", 10.1, moves=False), now=10.0, wall=HOLD_LIMIT + 3.0)
    demands.reached(10.1, wall=HOLD_LIMIT + 3.1)
    assert demands.holding


def test_demands_are_forgotten():
    demands = Demands()
    demands.note(wait("a", 10.0), now=5.0, wall=0.0)
    demands.clean(FORGET_AFTER - 0.1, here)
    assert demands.moving
    demands.clean(FORGET_AFTER + 0.1, here)
    assert not demands.moving
    demands.note(wait("gone", 5.0), now=5.0, wall=0.0)
    demands.clean(ABSENT_AFTER + 0.1, lambda _: False)
    assert not demands.holding


def test_time_is_announced_often_while_it_moves_and_seldom_when_it_stands():
    news = TimeNews()
    assert news.due_in(0.0, wall=0.0) == 0.0
    news.told(0.0, wall=0.0)
    assert news.due_in(0.0, wall=0.1) == pytest.approx(NEWS_STILL - 0.1)
    assert news.due_in(0.1, wall=0.01) == pytest.approx(NEWS_MOVING - 0.01)
    assert news.due_in(0.1, wall=0.01, resting=True) == 0.0
    assert news.due_in(0.0, wall=0.1, resting=True) > 0.0
    news.hurry()
    assert news.due_in(0.1, wall=0.01) == 0.0


@pytest.mark.parametrize(
    ("driven", "answered", "busy", "moving", "holding"),
    list(itertools.product([False, True], repeat=5)),
)
def test_lockstep_rule(driven, answered, busy, moving, holding):
    allowed = may_tick(driven=driven, answered=answered, busy=busy, moving=moving, holding=holding)
    if holding or (driven and not answered):
        assert not allowed
    elif moving:
        assert allowed
    else:
        assert allowed == (driven and busy)


def drive(tick, speed=0.5, *, busy=True):
    return Drive(tick=tick, speed=speed, turn_rate=0.1, busy=busy)


def test_driver_is_whoever_drives():
    driver = Driver()
    assert driver.name == "navigate"
    assert driver.hear(drive(3), "stand-in", tick=3)
    assert driver.name == "stand-in"
    assert driver.answered(3)
    assert driver.busy(3)
    assert not driver.answered(4)


def test_driver_may_answer_a_tick_again():
    driver = Driver()
    driver.hear(drive(3, busy=False), "navigate", tick=3)
    assert not driver.busy(3)
    driver.hear(drive(3, busy=True), "navigate", tick=3)
    assert driver.busy(3)


def test_late_and_early_answers_are_ignored_and_counted():
    driver = Driver()
    driver.hear(drive(5), "navigate", tick=5)
    assert not driver.hear(drive(4, speed=0.1), "navigate", tick=6)
    assert not driver.hear(drive(9), "navigate", tick=6)
    assert driver.ignored == 2
    assert driver.command(6) == (0.5, 0.1)


def test_who_answers_an_older_tick_than_the_driver_does_not_take_over():
    driver = Driver()
    driver.hear(drive(5), "navigate", tick=5)
    assert not driver.hear(drive(0, speed=0.1), "somebody", tick=5)
    assert (driver.name, driver.command(5)) == ("navigate", (0.5, 0.1))
    assert driver.hear(drive(6, speed=0.1), "somebody", tick=6)
    assert driver.name == "somebody"


def test_silent_driver_means_stop():
    driver = Driver()
    assert driver.command(0) == STOP
    driver.hear(drive(5), "navigate", tick=5)
    assert driver.command(5 + SILENCE) == (0.5, 0.1)
    assert driver.command(6 + SILENCE) == STOP


def test_forgotten_driver_means_stop():
    driver = Driver()
    driver.hear(drive(5), "navigate", tick=5)
    driver.forget()
    assert driver.command(5) == STOP
    assert not driver.answered(5)


def test_metronome_leaves_no_tick_out():
    metronome = Metronome(speed=2.0, wall=100.0)
    assert metronome.pause(100.0) == pytest.approx(0.05)
    assert metronome.pause(100.2) == 0.0
    assert metronome.pause(100.2) == 0.0
    assert metronome.pause(100.2) == pytest.approx(0.0, abs=1e-9)
    assert metronome.pause(100.2) == pytest.approx(0.05)


def test_metronome_gives_up_what_is_long_past():
    metronome = Metronome(speed=1.0, wall=0.0)
    assert metronome.pause(50.0) == 0.0
    assert metronome.pause(50.0) == pytest.approx(0.1)


def test_speed_flag():
    assert parse_speed("max") is None
    assert parse_speed("2.5") == 2.5
    for wrong in ("0", "-1", "nan", "inf", "fast"):
        with pytest.raises(ConfigError, match="a number above 0, or max"):
            parse_speed(wrong)


@pytest.mark.parametrize("speed", [None, 1.0, 20.0])
def test_restarted_world_goes_on_later_than_anybody_heard(tmp_path, speed):
    store = SnapshotFile(tmp_path)
    state = RobotState(World(PLAN, seed=3), SimClock(1000.0), speed=speed)
    state.world.set_door("r-5309", is_open=False)
    for _ in range(20):
        state.world.step(0.5, 0.0)
    saved = state.saved()
    store.save(saved)
    state.tick_limit = saved.tick_limit
    kept = state.world.truth()
    while not state.must_save:
        state.world.step(0.5, 0.0)
    loaded = store.load(floor=PLAN.name)
    again = RobotState(World(PLAN, seed=0), SimClock(0.0), speed=speed)
    again.restore(loaded, at_least=0.0)
    assert again.now > state.now
    assert again.world.tick > state.world.tick
    truth = again.world.truth()
    assert (truth.x, truth.y, truth.metres) == (kept.x, kept.y, kept.metres)
    assert again.world.doors()["r-5309"] is False
    assert again.must_save


def test_restored_clock_follows_the_wall_when_asked():
    state = RobotState(World(PLAN), SimClock(1000.0), speed=1.0)
    saved = state.saved()
    again = RobotState(World(PLAN), SimClock(0.0), speed=1.0)
    again.restore(saved, at_least=5000.0)
    assert again.now == pytest.approx(5000.0)
    again.restore(saved, at_least=0.0)
    assert again.now == pytest.approx(1000.0 + (saved.tick_limit + 1) * 0.1)


def test_no_snapshot_yet(tmp_path):
    assert SnapshotFile(tmp_path).load(floor="wean5") is None


def test_damaged_snapshot_is_a_clear_error(tmp_path):
    store = SnapshotFile(tmp_path)
    store.path.write_text('{"clock_start": 1')
    with pytest.raises(SnapshotError, match=r"xavier\.json is no snapshot.*--data"):
        store.load(floor="wean5")


def test_snapshot_of_another_floor_is_a_clear_error(tmp_path):
    store = SnapshotFile(tmp_path)
    store.save(RobotState(World(PLAN), SimClock(0.0), speed=None).saved())
    with pytest.raises(SnapshotError, match="is of floor 'wean5', expected 'other'"):
        store.load(floor="other")


def test_folder_that_cannot_be_written_is_a_clear_error(tmp_path):
    (tmp_path / "file").write_text("")
    store = SnapshotFile(tmp_path / "file")
    with pytest.raises(SnapshotError, match=r"xavier\.json cannot be written \("):
        store.save(RobotState(World(PLAN), SimClock(0.0), speed=None).saved())


def test_snapshot_leaves_no_partial_file(tmp_path):
    SnapshotFile(tmp_path).save(RobotState(World(PLAN), SimClock(0.0), speed=None).saved())
    assert [path.name for path in tmp_path.iterdir()] == ["xavier.json"]


@pytest.mark.parametrize(
    ("world", "flags", "says"),
    [
        ({}, {"speed": "fast"}, "--speed is 'fast', expected a number above 0, or max"),
        ({"seed": -1}, {}, "--seed is -1, expected 0 or more"),
        ({"battery": 0.0}, {}, "--battery is 0.0, expected hours above 0"),
        ({}, {"epoch": "noon"}, "--epoch is 'noon', expected an ISO 8601 time"),
        ({}, {"epoch": "1960-01-01"}, "--epoch is '1960-01-01', expected .* of the years 1970 to"),
        ({}, {"epoch": "9999-12-31"}, "--epoch is '9999-12-31', expected .* of the years 1970 to"),
    ],
)
def test_bad_flags(world, flags, says):
    wanted = {"speed": "1", "data": None, "epoch": None, **flags}
    with pytest.raises(ConfigError, match=says):
        open_world(WorldFlags(rays="numpy", **world), **wanted)


def test_world_is_opened_where_it_was_left(tmp_path):
    world = WorldFlags(seed=4, people_walking=2, carts=1, rays="numpy")
    wanted = {"speed": "max", "data": tmp_path, "epoch": "1997-06-02T09:00+00:00"}
    state, store = open_world(world, **wanted)
    assert state.now == 865242000.0
    for _ in range(20):
        state.world.step(0.5, 0.0)
    store.save(state.saved())
    again, _ = open_world(world, **wanted)
    assert again.now > state.now
    assert again.world.truth().metres == state.world.truth().metres
    assert again.world.discs == state.world.discs


def test_world_comes_back_from_disk_bit_for_bit(tmp_path):
    store = SnapshotFile(tmp_path)
    state = RobotState(World(PLAN, seed=3), SimClock(1000.0), speed=None)
    for _ in range(37):
        state.world.step(0.5, 0.3)
    store.save(state.saved())
    assert store.load(floor=PLAN.name).world == state.world.snapshot()


@pytest.mark.parametrize(
    "spoil",
    [
        lambda world: world.pop("doors"),
        lambda world: world["robots"]["xavier"].pop("body"),
        lambda world: world["robots"]["xavier"]["body"].update(x="east"),
        lambda world: world["robots"]["xavier"]["odometry"].update(pose=[1.0]),
    ],
)
def test_damaged_state_of_a_world_is_named(tmp_path, spoil):
    store = SnapshotFile(tmp_path)
    saved = RobotState(World(PLAN), SimClock(0.0), speed=None).saved()
    spoil(saved.world)
    store.save(saved)
    with pytest.raises(SnapshotError, match=r"xavier\.json holds no state of such a world"):
        open_world(WorldFlags(rays="numpy"), speed="1", data=tmp_path, epoch=None)
