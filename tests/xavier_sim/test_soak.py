"""The soak: errands without end, judged by the truth, resumed bit for bit."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from xavier_sim.floors import FloorError, load_floor
from xavier_sim.profile import PROFILES
from xavier_sim.running import RobotState, SimClock
from xavier_sim.sensors import NoSensorError
from xavier_sim.soak import (
    FAULT_KINDS,
    Course,
    Job,
    NavigatorError,
    Soak,
    SoakOptions,
    Way,
    load_factory,
    possible_faults,
)
from xavier_sim.soak._doors import DoorKeeper
from xavier_sim.soak._histogram import Histogram
from xavier_sim.soak._loading import make_navigator
from xavier_sim.soak._mishaps import Mishaps
from xavier_sim.soak._reaching import Reach
from xavier_sim.world import World

FLOOR = str(Path(__file__).parent / "soak_floor.yaml")
QUICK = {"floor": FLOOR, "rays": "numpy"}
"""A small floor, and no time spent on loading numba."""


def soak_of(**options):
    return Soak(SoakOptions(**{**QUICK, "seed": 3, "shut_share": 0.0, **options}))


def test_a_robot_runs_errands_from_room_to_room():
    soak = soak_of()
    job = soak.run_job()
    assert 0.0 < job.last_off <= job.worst_off < 0.5
    assert (job.outcome, job.way, job.false_arrival) == ("arrived", Way.OPEN, False)
    assert job.metres > 1.0
    assert job.seconds > 3.0
    assert job.off < 0.5
    assert soak.world.truth().space == job.goal
    assert soak.run_job().start == job.goal


def test_a_door_that_stays_shut_is_the_right_reason_to_give_up():
    soak = soak_of(shut_share=1.0, door_moves_per_hour=0.0)
    job = soak.run_job()
    assert (job.way, job.reason) == (Way.SHUT, "door_blocked")
    assert job.refused_rightly
    assert not job.arrived


@pytest.mark.parametrize(
    "options",
    [
        {"shut_share": 0.3, "door_moves_per_hour": 60.0},
        {"people": 1, "fault": "slip", "profile": "hard"},
        {"fault": "sonar-stuck", "navigator_options": {"localizer": "particles"}},
    ],
)
def test_a_resumed_soak_is_the_same_bit_for_bit(options):
    straight = soak_of(**options)
    straight.run_job()
    kept = json.loads(json.dumps(straight.snapshot()))
    resumed = soak_of(**options)
    resumed.restore(kept)
    assert straight.run_job() == resumed.run_job()
    assert straight.snapshot() == resumed.snapshot()


def test_a_robot_that_fails_again_and_again_is_helped():
    soak = soak_of(navigator="soak_sleeper:Sleeper", rest=0.0)
    jobs = [soak.run_job() for _ in range(3)]
    assert [job.reason for job in jobs] == ["asleep"] * 3
    assert soak.course.tally.rescues == 1
    assert soak.navigator.told == [(3.6, 1.2, 0.0)]


def test_navigators_are_had_by_name_or_by_import_string():
    assert load_factory("navigate") is load_factory("navigate.factory:make_navigator")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("navigat", "is not installed; installed: navigate."),
        ("nowhere.at:all", "cannot be imported: No module named 'nowhere'"),
        ("math:pi", "is a float, expected a callable"),
        ("math:", "is neither installed nor named as module:attribute"),
    ],
)
def test_a_navigator_that_cannot_be_had_is_explained(name, why):
    with pytest.raises(NavigatorError) as caught:
        load_factory(name)
    assert why in str(caught.value)
    assert caught.value.name == name


def test_errands_need_two_places():
    plan = load_floor(FLOOR)
    alone = plan.model_copy(update={"places": {"r-1": plan.places["r-1"]}})
    with pytest.raises(FloorError, match="number of places is '1', expected 2 or more"):
        Course(alone, SoakOptions(**QUICK))


def test_what_a_navigator_lacks_is_named():
    with pytest.raises(NavigatorError, match="makes a Lame, which lacks cancel, freeze, pose"):
        make_navigator(f"{__name__}:Lame", load_floor(FLOOR), seed=0, options={})


class Lame:
    def __init__(self, plan, *, seed):
        pass

    def step(self, sensors):
        pass


def test_reach_follows_open_doors():
    plan = load_floor(FLOOR)
    reach, doors = Reach(plan), {"d-1": True, "d-2": False, "d-3": True}
    assert reach.reachable("r-1", "r-3", doors)
    assert not reach.reachable("r-1", "r-2", doors)
    assert reach.reachable("r-2", "r-2", doors)


def test_doors_are_wanted_shut_for_their_share_of_the_time():
    keeper = DoorKeeper(("a", "b", "c"), shut_share=0.25, moves_per_hour=3600.0, seed=1)
    stand = dict(keeper.furnish())
    assert list(stand) == ["a", "b", "c"]
    shut, moves = Counter(), 0
    for tick in range(0, 30_000, 10):
        due = keeper.due(tick)
        moves += len(due)
        stand.update(due)
        shut.update(door for door, is_open in stand.items() if not is_open)
    assert 0.2 < shut.total() / (3 * 3000) < 0.3
    assert 8_000 < moves < 10_000


def test_a_door_is_due_at_its_tick_and_not_before():
    keeper = DoorKeeper(("a",), shut_share=0.5, moves_per_hour=60.0, seed=1)
    due_at = math.ceil(keeper.next_tick)
    assert keeper.due(due_at - 1) == []
    assert [move.door for move in keeper.due(due_at)] == ["a"]
    assert keeper.next_tick > due_at


def test_doors_that_nobody_moves_are_never_due():
    keeper = DoorKeeper(("a",), shut_share=0.5, moves_per_hour=0.0, seed=1)
    assert keeper.next_tick == math.inf
    assert keeper.due(10**9) == []


def test_a_door_does_not_move_through_the_robot():
    soak = soak_of(shut_share=1.0, door_moves_per_hour=3600.0, navigator="soak_sleeper:Sleeper")
    soak.world.set_door("d-1", is_open=True)
    soak.world.place_robot(1.8, 2.4, 0.0)
    for _ in range(2):
        soak.run_job()
    assert soak.world.open_doors == {"d-1": True, "d-2": False, "d-3": False}
    assert soak.course.tally.door_moves == 0


@given(st.lists(st.floats(0.0, 3.0), min_size=1, max_size=60), st.floats(0.01, 1.0))
@settings(max_examples=40)
def test_quantiles_are_right_within_a_bin(values, share):
    histogram = Histogram(width=0.01, bins=400)
    for value in values:
        histogram.add(value)
    found = histogram.quantile(share)
    below = sum(value <= found for value in values)
    assert below >= share * len(values) - 1e-6
    width = 0.01 + 1e-9
    assert sum(value < found - width for value in values) < share * len(values) + 1e-6
    assert histogram.most == max(values)


@pytest.mark.parametrize("kind", FAULT_KINDS)
def test_each_kind_of_fault_is_done_when_it_is_due(kind):
    world = World(load_floor(FLOOR), 0, PROFILES["hard"])
    before = faults_of(world)
    mishaps = Mishaps(kind, 1)
    struck = [mishaps.begin(world)]
    world.tick = 12_000 if kind == "kidnap" else 6_000
    struck.append(mishaps.tend(world))
    assert faults_of(world) != before
    done = faults_of(world)
    struck.append(mishaps.tend(world))
    assert faults_of(world) == done, "once only"
    assert struck.count(True) == 1


@pytest.mark.parametrize(("kind", "count"), [("sonar-dead", 1), ("kidnap", 0)])
def test_how_often_a_fault_struck_is_counted_and_kept(kind, count):
    soak = soak_of(fault=kind)
    soak.run_job()
    assert soak.course.tally.faults == count
    kept = json.loads(json.dumps(soak.snapshot()))
    soak.course.tally.faults = 7
    soak.restore(kept)
    assert soak.course.tally.faults == count


def faults_of(world):
    robot = world.snapshot()["robots"]["xavier"]
    return json.dumps(robot), RobotState(world, SimClock(0.0), speed=None).fault_state()


def test_a_sensor_that_is_not_there_cannot_fail():
    with pytest.raises(NoSensorError):
        soak_of(profile="modern", fault="sonar-dead")


@pytest.mark.parametrize("name", sorted(PROFILES))
@pytest.mark.parametrize("kind", FAULT_KINDS)
def test_which_faults_a_robot_can_have_is_known_before(name, kind):
    world = World(load_floor(FLOOR), 1, PROFILES[name])
    try:
        Mishaps(kind, 1).begin(world)
    except NoSensorError:
        assert kind not in possible_faults(PROFILES[name])
    else:
        assert kind in possible_faults(PROFILES[name])


def job_of(**facts):
    plain = {
        "number": 0, "began": 0.0, "start": "r-1", "goal": "r-2", "way": "open", "reason": None,
        "seconds": 20.0, "metres": 8.0, "x": 5.4, "y": 3.0,
        "off": 0.1, "mean_off": 0.05, "worst_off": 0.2, "confidence": 0.9,
        "recoveries": 0, "bumps": 0,
    }  # fmt: skip
    return Job(**{**plain, **facts})


@pytest.mark.parametrize(
    ("facts", "outcome", "rightly"),
    [
        ({}, "arrived", False),
        ({"off": 0.6}, "elsewhere", False),
        ({"reason": "no_route"}, "no_route", False),
        ({"reason": "no_route", "way": "shut"}, "no_route", True),
        ({"reason": "door_blocked", "way": "changing"}, "door_blocked", True),
        ({"reason": "lost", "way": "shut"}, "lost", False),
    ],
)
def test_a_job_is_judged_by_the_truth(facts, outcome, rightly):
    job = job_of(**facts)
    assert (job.outcome, job.refused_rightly) == (outcome, rightly)
    assert job.false_arrival == (outcome == "elsewhere")
