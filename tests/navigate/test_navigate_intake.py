"""Sensor readings that are doubled, late, missing, useless, or of another time."""

from __future__ import annotations

import asyncio
import itertools
import logging
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from navigate_office import running
from navigate_readings import reading

from navigate.maps import Floor, load_plan
from navigate.messages import NavigateToGoal, NavigationReport, StopDriving, WhereAmI
from navigate.navigator import Navigator
from navigate.service import NavigateService, _goal_desk, _helm, _sparing
from navigate.service._followed import GONE_SECONDS, MOST_NAMED, Followed
from navigate.service._intake import STILL, Intake, Kind
from tca_bus import InvalidMessageError, Module, TaskError, TaskFailedError
from tca_bus._clock import WallClock
from tca_bus.testing import ManualClock, bus, central, eventually
from xavier_sim.messages import Drive


def floats(*shape, value=1.0):
    return np.full(shape, value, dtype=np.float32)


def judged(*readings):
    intake = Intake()
    return [intake.judge(one) for one in readings]


@given(st.lists(st.integers(0, 3), min_size=1, max_size=30))
def test_readings_in_order_are_new_and_doubled_ones_are_not(steps):
    ticks = list(itertools.accumulate(steps))
    kinds = [one.kind for one in judged(*(reading(tick) for tick in ticks))]
    assert kinds[0] is Kind.NEW
    expected, run = [], 0
    for step in steps[1:]:
        run = 0 if step else run + 1
        expected.append(Kind.NEW if step else Kind.AGAIN if run < STILL else Kind.USELESS)
    assert kinds[1:] == expected


def test_a_reading_that_is_said_for_ever_is_no_news_unless_somebody_waits_for_the_answer():
    last = judged(*[reading(7)] * (STILL + 1))[-1]
    assert (last.kind, last.word) == (Kind.USELESS, "time stands still at 1000.7 s")
    waiting = judged(*[reading(7, lockstep=True)] * 100)[-1]
    assert waiting.kind is Kind.AGAIN


@given(st.permutations(range(3)))
def test_stragglers_change_nothing(order):
    late = [judgement.kind for judgement in judged(reading(9), *map(reading, order))[1:3]]
    assert late == [Kind.LATE, Kind.LATE]
    intake = Intake()
    for tick in (9, *sorted(order, reverse=True), 10):
        last = intake.judge(reading(tick))
    assert last.kind is Kind.NEW


@pytest.mark.parametrize(
    ("readings", "kind", "word"),
    [
        ([reading(1), reading(2, 1000.1)], Kind.USELESS, "time stands still at 1000.1 s"),
        ([reading(1), reading(2, 4600.0)], Kind.LEAPT, "time has jumped by +3599.9 s"),
        ([reading(500), reading(501, 900.0)], Kind.LEAPT, "time has jumped by -150.0 s"),
        ([reading(500), *map(reading, (3, 4, 5))], Kind.LEAPT, "time has jumped by -49.5 s"),
        ([reading(500), reading(0, lockstep=True)], Kind.LEAPT, "time has jumped by -50.0 s"),
        ([reading(1), reading(9)], Kind.NEW, "7 readings before it are missing"),
        ([reading(1), reading(4)], Kind.NEW, None),
        (
            [reading(600), reading(0, 1070.0)],
            Kind.LEAPT,
            "its counter fell from 600: the robot was started again",
        ),
        ([reading(600), reading(0, 1070.0), reading(1, 1070.1)], Kind.NEW, None),
        ([reading(600, lockstep=True), reading(595, 1060.1, lockstep=True)], Kind.NEW, None),
        (
            [reading(600, lockstep=True), reading(649, lockstep=True)],
            Kind.NEW,
            "48 readings before it are missing",
        ),
        ([reading(1), reading(700)], Kind.NEW, "698 readings before it are missing"),
        ([reading(1, sonar=floats(23))], Kind.USELESS, "sonar has 23 readings, expected 24"),
        ([reading(1, sonar=floats())], Kind.USELESS, "sonar has 1 readings, expected 24"),
        ([reading(1, speed=math.inf)], Kind.USELESS, "speed is inf m/s, expected -10 to 10"),
        ([reading(1, speed=math.nan)], Kind.USELESS, "speed is nan m/s, expected -10 to 10"),
        (
            [reading(1, turn_rate=-1e9)],
            Kind.USELESS,
            "turn_rate is -1e+09 rad/s, expected -20 to 20",
        ),
        (
            [reading(1, odom=floats(3, value=2.0**100))],
            Kind.USELESS,
            f"odom is {[2.0**100] * 3}, expected three numbers from -100000 to 100000",
        ),
        (
            [reading(1, odom=floats(3, value=math.nan))],
            Kind.USELESS,
            "odom is [nan, nan, nan], expected three numbers from -100000 to 100000",
        ),
        (
            [reading(1, striper=floats(31, 2))],
            Kind.USELESS,
            "striper has 62 readings, expected 31 or none, in one row",
        ),
        (
            [reading(1, lidar=floats(31))],
            Kind.USELESS,
            "lidar has 31 readings, expected 180 or none, in one row",
        ),
        ([reading(1, period=math.inf)], Kind.USELESS, "period is inf, expected a finite number"),
    ],
)
def test_what_is_amiss_has_a_name_and_a_word(readings, kind, word):
    last = judged(*readings)[-1]
    assert (last.kind, last.word) == (kind, word)


class Deaf:
    """Takes what the helm says."""

    def serve(self, *_):
        """Take any handler."""

    async def inform(self, _message):
        """Take any command."""

    def modules(self):
        """Name the robots that are there."""
        return [SimpleNamespace(name=name) for name in ("robot", "other")]


ROBOT = SimpleNamespace(sender="robot")


async def nothing(_leapt):
    """Do nothing after a step."""


def fails(error):
    """Let no step of the navigator fail unseen."""
    raise error


@pytest.fixture
def wall(monkeypatch):
    """A wall clock that the test moves."""
    clock = SimpleNamespace(now=100.0)
    for module in (_helm, _sparing):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock.now))
    return clock


async def test_a_world_that_stands_still_but_says_so_is_no_silence(wall):
    helm = _helm.Helm(Navigator(Floor(load_plan())), Deaf(), nothing, fails)
    for _ in range(5):
        await helm._on_sensors(reading(1, lockstep=True), ROBOT)
        helm.check_heard()
        wall.now += 20.0
    wall.now += 20.0
    with pytest.raises(_helm.SilentRobotError, match="no sensor readings"):
        helm.check_heard()


async def test_patience_with_a_robot_runs_from_its_last_reading_of_use_or_from_a_goal(wall):
    helm = _helm.Helm(Navigator(Floor(load_plan())), Deaf(), nothing, fails)
    await helm._on_sensors(reading(1), ROBOT)
    wall.now += 20.0
    assert helm.patience() == 10.0
    await helm._on_sensors(reading(2, speed=math.nan), ROBOT)
    assert helm.patience() == 10.0
    await helm._on_sensors(reading(3), ROBOT)
    assert helm.patience() == 30.0
    wall.now += 40.0
    assert helm.patience() == 0.0
    await helm.first_sensors()
    assert helm.patience() == 30.0


class Watch:
    """An errand that waits, on a wall clock that goes on by what is waited for."""

    def __init__(self, wall):
        self.wall, self.waited = wall, []

    def timeout(self, seconds):
        self.waited.append(seconds)
        self.wall.now += seconds
        return asyncio.timeout(0.0)


async def test_a_drive_waits_for_its_robot_until_it_is_silent_for_so_long_and_no_longer(
    wall, monkeypatch
):
    navigator, watch = Navigator(Floor(load_plan())), Watch(wall)
    helm = _helm.Helm(navigator, Deaf(), nothing, fails)
    desk = _goal_desk.GoalDesk(navigator, Deaf(), helm, None)
    await helm._on_sensors(reading(1), ROBOT)
    desk._errand = navigator.start((21.87, 70.0), helm.sensors)
    wall.now += 12.0
    fake = SimpleNamespace(timeout=watch.timeout)
    monkeypatch.setattr(_goal_desk, "asyncio", fake)
    with pytest.raises(TaskError, match="no sensor readings of use for 30 s"):
        await desk._until_ended()
    assert watch.waited == [18.0]


async def test_gaps_that_come_and_go_get_one_word_a_minute(wall, caplog):
    helm = _helm.Helm(Navigator(Floor(load_plan())), Deaf(), nothing, fails)
    for tick in itertools.chain.from_iterable((n, n + 1) for n in range(0, 200, 10)):
        await helm._on_sensors(reading(tick), ROBOT)
        wall.now += 2.0
    assert sum("are missing" in word for word in caplog.messages) == 2


async def test_useless_readings_that_come_and_go_get_one_word_a_minute_whatever_they_say(
    wall, caplog
):
    helm = _helm.Helm(Navigator(Floor(load_plan())), Deaf(), nothing, fails)
    for tick in range(20):
        fields = {} if tick % 2 else {"speed": 100.0 + tick}
        await helm._on_sensors(reading(tick, **fields), ROBOT)
        wall.now += 4.0
    assert [word[:21] for word in caplog.messages] == [
        "sensors of tick 0: sp",
        "sensors of tick 16: s",
    ]


async def test_what_lasts_is_said_once_though_its_words_change(wall, caplog):
    helm = _helm.Helm(Navigator(Floor(load_plan())), Deaf(), nothing, fails)
    for tick in range(20):
        await helm._on_sensors(reading(tick, speed=100.0 + tick), ROBOT)
        wall.now += 10.0
    assert len(caplog.messages) == 1


def followed(*present):
    there = set(present)
    return Followed(there.__contains__), there


def test_one_robot_is_followed_and_the_other_left_aside_with_one_word():
    robots, _ = followed("one", "two")
    taken = [robots.judge(name, tick / 10) for tick in range(300) for name in ("one", "two")]
    assert [verdict.taken for verdict in taken] == [True, False] * 300
    words = [verdict.word for verdict in taken if verdict.word]
    assert words == ["two robots send readings: follows one, and leaves those of two aside"]


def test_no_more_than_some_robots_get_a_word():
    robots, _ = followed("one")
    robots.judge("one", 0.0)
    verdicts = [robots.judge(f"robot-{number}", 0.1) for number in range(3 * MOST_NAMED)]
    assert sum(verdict.word is not None for verdict in verdicts) == MOST_NAMED


@pytest.mark.parametrize(
    ("leaves", "now", "taken"),
    [
        (True, 0.1, True),
        (False, 0.1, False),
        (False, GONE_SECONDS - 0.1, False),
        (False, GONE_SECONDS, True),
    ],
)
def test_another_robot_is_followed_once_the_first_has_left_or_is_silent(leaves, now, taken):
    robots, there = followed("one", "two")
    robots.judge("one", 0.0)
    if leaves:
        there.remove("one")
    verdict = robots.judge("two", now)
    assert (verdict.taken, verdict.other) == (taken, taken)
    assert robots.judge("one", now).taken is not taken


def test_robots_that_are_not_seen_on_the_bus_have_not_left_it():
    robots, _ = followed()
    assert [robots.judge(name, 0.1).taken for name in ("one", "two", "one")] == [True, False, True]


def test_a_robot_that_is_started_again_under_its_name_is_the_same():
    robots, there = followed("one", "two")
    robots.judge("one", 0.0)
    there.remove("one")
    again = robots.judge("one", 100.0)
    assert (again.taken, again.other, again.word) == (True, False, None)


async def test_two_robots_on_one_realm_are_one_to_the_navigator(wall, caplog):
    navigator = Navigator(Floor(load_plan()))
    leaps = []

    async def stepped(leapt):
        leaps.append(leapt)

    helm = _helm.Helm(navigator, Deaf(), stepped, fails)
    other = SimpleNamespace(sender="other")
    for tick in range(20):
        await helm._on_sensors(reading(tick), ROBOT)
        await helm._on_sensors(reading(tick, 9000.0, odom=floats(3, value=430.0)), other)
        wall.now += 0.1
    assert helm.sensors.time == navigator.time == 1001.9
    assert leaps == [False] * 20
    assert len(caplog.messages) == 1
    wall.now += GONE_SECONDS
    await helm._on_sensors(reading(3, 1001.95), other)
    assert navigator.time == 1001.95
    assert leaps[20:] == [True]
    assert caplog.messages[1:] == ["follows the robot other from now on: robot is gone"]


class Timed(Deaf):
    """Has a clock besides."""

    def __init__(self, clock):
        self.clock = clock


async def test_the_end_of_a_drive_waits_for_no_robot_on_the_wall_clock(monkeypatch, caplog):
    monkeypatch.setattr(_helm, "CLOCK_SECONDS", 0.01)
    helm = _helm.Helm(Navigator(Floor(load_plan())), Timed(WallClock()), nothing, fails)
    await helm._on_sensors(reading(437, 1e12, lockstep=True), ROBOT)
    await helm.until_told()
    assert "nobody tells the time" not in caplog.text


@pytest.mark.parametrize(("told", "words"), [(1043.7, 0), (1043.6, 1)])
async def test_the_end_of_a_drive_waits_until_its_time_is_told(told, words, monkeypatch, caplog):
    monkeypatch.setattr(_helm, "CLOCK_SECONDS", 0.01)
    clock = ManualClock(0.0)
    helm = _helm.Helm(Navigator(Floor(load_plan())), Timed(clock), nothing, fails)
    await helm._on_sensors(reading(437, lockstep=True), ROBOT)
    clock.move_to(told)
    await helm.until_told()
    assert caplog.messages.count("nobody tells the time of tick 437") == words


class Robot:
    """Sends readings over a bus by hand, and keeps the commands that come back."""

    def __init__(self, options):
        self.module = Module("robot", options=options)
        self.module.serve(Drive, self.take)
        self.heard = asyncio.Queue()

    async def take(self, drive, _context):
        self.heard.put_nowait(drive)

    async def send(self, one):
        """Send a reading; gives the command that answers it."""
        await self.module.broadcast(one)
        async with asyncio.timeout(10):
            while (drive := await self.heard.get()).tick != one.tick:
                pass
        return drive


@pytest.mark.bus
async def test_a_leap_in_time_begins_the_drive_anew_and_is_told_once(caplog):
    async with bus() as options, central(options):
        navigator = Navigator(Floor(load_plan()))
        service, robot = NavigateService(navigator, options), Robot(options)
        async with robot.module, running(service.run()):
            await robot.module.wait_for(NavigateToGoal, timeout=10)
            await service.module.wait_for(Drive, timeout=10)
            await robot.send(reading(1))
            goal = NavigateToGoal(x=2187.0, y=7000.0)
            handle = await robot.module.expand(goal, wait_for_handler=10)
            await eventually(lambda: navigator.busy)
            first = navigator.driver.drive
            assert (await robot.send(reading(2))).busy
            with caplog.at_level(logging.WARNING, "navigate"):
                for tick in (3, 4):
                    stopped = await robot.send(reading(tick, 1000.2))
                    assert (stopped.speed, stopped.turn_rate) == (0.0, 0.0)
                await robot.send(reading(5, 400.0))
                await robot.send(reading(6, 400.1))
            assert navigator.driver.drive is not first
            assert navigator.driver.drive.began == 400.0
            assert navigator.busy
            await handle.kill("enough")
    words = [record.getMessage() for record in caplog.records]
    assert sum("time stands still at 1000.2 s" in word for word in words) == 1
    assert sum("time has jumped by -600.2 s" in word for word in words) == 1


@pytest.mark.bus
async def test_a_robot_that_falls_silent_ends_the_drive(monkeypatch):
    monkeypatch.setattr(_helm, "SENSOR_SECONDS", 0.3)
    async with bus() as options, central(options):
        service, robot = NavigateService(Navigator(Floor(load_plan())), options), Robot(options)
        async with robot.module, running(service.run()):
            await robot.module.wait_for(NavigateToGoal, timeout=10)
            await service.module.wait_for(Drive, timeout=10)
            await robot.send(reading(1))
            goal = NavigateToGoal(x=2187.0, y=7000.0)
            handle = await robot.module.expand(goal, wait_for_handler=10)
            with pytest.raises(TaskFailedError, match="no sensor readings") as caught:
                await handle.result(timeout=20)
            assert caught.value.failure.name == "lost"
            report = NavigationReport.model_validate(caught.value.failure.data)
            assert (report.outcome, report.position.time) == ("lost", reading(1).time)
            assert (await robot.module.query(WhereAmI())).time == reading(1).time


@pytest.mark.bus
async def test_a_goal_that_is_stopped_before_the_robot_says_anything_never_begins():
    async with bus() as options, central(options):
        navigator = Navigator(Floor(load_plan()))
        service, robot = NavigateService(navigator, options), Robot(options)
        async with robot.module, running(service.run()):
            await robot.module.wait_for(NavigateToGoal, timeout=10)
            await service.module.wait_for(Drive, timeout=10)
            handle = await robot.module.expand(NavigateToGoal(x=2187.0, y=7000.0))
            await eventually(lambda: service._goals._waits)
            await robot.module.query(StopDriving())
            await robot.send(reading(1))
            with pytest.raises(TaskFailedError, match=r"set out for .*stopped by") as caught:
                await handle.result(timeout=20)
            assert caught.value.failure.name == "cancelled"
            report = NavigationReport.model_validate(caught.value.failure.data)
            assert (report.outcome, report.metres, report.seconds) == ("cancelled", 0.0, 0.0)
            assert not navigator.busy


@pytest.mark.bus
async def test_a_goal_for_a_robot_that_never_said_anything_fails_with_a_report(monkeypatch):
    monkeypatch.setattr(_helm, "SENSOR_SECONDS", 0.1)
    async with bus() as options, central(options):
        service = NavigateService(Navigator(Floor(load_plan())), options)
        asker = Module("asker", options=options)
        async with asker, running(service.run()):
            await asker.wait_for(NavigateToGoal, timeout=10)
            handle = await asker.expand(NavigateToGoal(x=2187.0, y=7000.0), wait_for_handler=10)
            with pytest.raises(TaskFailedError, match="no sensor readings") as caught:
                await handle.result(timeout=20)
    assert caught.value.failure.name == "lost"
    report = NavigationReport.model_validate(caught.value.failure.data)
    assert (report.outcome, report.metres, report.position.heard) == ("lost", 0.0, False)


async def drive_to(module, x):
    handle = await module.submit_json(
        "navigateToG", {"x": x, "y": 0.0}, task_class="goal", wait_for_handler=10
    )
    await handle.result(timeout=10)


@pytest.mark.parametrize("where", ["NaN", "Infinity", "-Infinity", "1e999", "north"])
@pytest.mark.bus
async def test_a_goal_that_is_no_place_is_refused_by_its_field(where):
    async with bus() as options, central(options):
        service = NavigateService(Navigator(Floor(load_plan())), options)
        asker = Module("asker", options=options)
        async with asker, running(service.run()):
            await asker.wait_for(NavigateToGoal, timeout=10)
            with pytest.raises((InvalidMessageError, TaskFailedError), match="x: "):
                await drive_to(asker, where)
