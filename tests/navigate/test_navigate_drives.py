"""Whole drives in the simulated world, in this process."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from navigate_loop import Loop, true_plan, with_box

from navigate.body import wrap
from navigate.driving import STOP, DoorLog, DoorTally
from navigate.driving._view import Disobeyed
from navigate.freezing import freeze, thaw
from navigate.maps import Floor, UnknownRoomError, load_plan
from navigate.messages import NavigationFailure
from navigate.navigator import Navigator
from xavier_sim.body import Battery
from xavier_sim.messages import SonarFault
from xavier_sim.profile import BatteryProfile
from xavier_sim.running import Reflex, make_fault


def test_errands_from_room_to_room_arrive_where_they_should():
    loop = Loop(seed=4)
    for room in ("r-5303", "r-5302", "r-5304"):
        drive = loop.drive(room)
        assert drive.failure is None
        assert loop.off(room) < 0.25
        assert loop.astray() < 0.25
        assert loop.navigator.position().room == room
    report = loop.navigator.report(drive)
    assert report.metres == pytest.approx(drive.metres, abs=0.01)
    assert loop.world.truth().bumps == 0


def test_the_jambs_of_a_door_tell_which_way_the_robot_looks(monkeypatch):
    loop, told = Loop(seed=4), []
    localizer = loop.navigator.localizer
    orient = localizer.orient

    def listen(theta, *, spread):
        told.append((wrap(theta - loop.world.pose[2]), spread))
        orient(theta, spread=spread)

    monkeypatch.setattr(localizer, "orient", listen)
    loop.drive("r-5303")
    loop.drive("r-5304")
    assert len(told) == 3  # in, out, and into the other room
    for off, spread in told:
        assert abs(off) < 3.0 * spread < math.radians(8.0)


def test_odometry_that_is_set_anew_is_no_way_driven():
    loop = Loop(seed=4)
    drive = loop.start("r-5303")
    loop.rest(20)
    before = drive.metres
    odom = loop.sensors.odom + np.array([500.0, 0.0, 0.0], dtype=np.float32)
    later = {"odom": odom, "time": loop.sensors.time + 0.1}
    loop.navigator.step(loop.sensors.model_copy(update=later))
    assert drive.metres == before


def test_the_same_seed_drives_the_same_way():
    def run():
        loop = Loop(seed=7)
        loop.start("r-5303")
        loop.rest(150)
        return loop.world.truth(), loop.navigator.position()

    assert run() == run()


def test_a_shut_door_is_waited_for_then_reported_and_remembered():
    loop = Loop(seed=1)
    loop.world.set_door("r-5303", is_open=False)
    drive = loop.drive("r-5303")
    assert drive.failure.reason is NavigationFailure.DOOR_BLOCKED
    assert "d-5303" in drive.failure.text
    report = loop.navigator.report(drive)
    assert 40.0 < report.seconds < 120.0
    assert report.door == "r-5303"
    assert loop.world.truth().bumps == 0
    again = loop.drive("r-5303")
    assert again.failure.reason is NavigationFailure.DOOR_BLOCKED
    assert again.recoveries == 0
    loop.world.set_door("r-5303", is_open=True)
    assert loop.drive("r-5303").failure is None
    assert loop.off("r-5303") < 0.25


def test_shut_in_it_looks_at_the_door_again_on_each_drive():
    loop = Loop(seed=1)
    loop.drive("r-5303")
    loop.world.set_door("r-5303", is_open=False)
    for room in ("r-5305", "r-5302"):
        drive = loop.drive(room)
        assert drive.failure.reason is NavigationFailure.DOOR_BLOCKED
        assert "d-5303" in drive.failure.text
        assert loop.navigator.report(drive).seconds > 40.0
    loop.world.set_door("r-5303", is_open=True)
    assert loop.drive("r-5305").failure is None


def test_a_door_that_is_told_to_be_open_again_is_not_driven_round():
    loop = Loop()
    navigator, now = loop.navigator, loop.sensors.time
    navigator.memory.shut("d-5303", now)
    navigator.hear_opened("r-5302")
    assert navigator.memory.believed(now).doors == {"d-5303"}
    navigator.hear_opened("r-5303")
    assert not navigator.memory.believed(now).doors


def test_a_door_that_opens_in_time_is_passed():
    loop = Loop(seed=2)
    loop.world.set_door("r-5303", is_open=False)
    ticks = iter(range(10_000))

    def open_later():
        if next(ticks) == 450:
            loop.world.set_door("r-5303", is_open=True)

    assert loop.drive("r-5303", each=open_later).failure is None
    assert loop.off("r-5303") < 0.25


def test_what_stands_in_the_corridor_is_passed():
    loop = Loop(3, with_box(true_plan(), (6.5, 20.5), (7.5, 21.3)))
    assert loop.drive("r-5303").failure is None
    assert loop.off("r-5303") < 0.25
    assert loop.world.truth().bumps == 0


def test_a_blocked_corridor_is_driven_round():
    loop = Loop(1, with_box(true_plan(), (6.4, 17.9), (8.7, 18.6)))
    drive = loop.drive("r-5302", most=6000)
    assert drive.failure is None
    assert loop.off("r-5302") < 0.25
    assert loop.navigator.report(drive).recoveries == 1


def test_a_floor_blocked_off_fails_as_such():
    loop = Loop(1, with_box(true_plan(), (4.1, 14.0), (12.3, 14.8)))
    drive = loop.drive("r-5303", most=6000)
    assert drive.failure.reason is NavigationFailure.CORRIDOR_BLOCKED
    assert loop.navigator.wheels == STOP


@pytest.mark.parametrize("lost", [False, True])
@pytest.mark.parametrize("goal", [(-100.0, 0.0), (4.05, 9.0)])
def test_a_point_where_no_robot_can_stand_has_no_route_at_once(goal, lost):
    loop = Loop()
    if lost:
        loop.navigator.localizer.forget()
    assert loop.navigator.localizer.lost is lost
    drive = loop.navigator.start(goal, loop.sensors)
    assert drive.done
    assert drive.failure.reason is NavigationFailure.NO_ROUTE
    assert "no route to" in drive.failure.text


def test_a_point_that_is_no_place_is_reached():
    loop = Loop()
    drive = loop.navigator.start((12.0, 16.5), loop.sensors)
    while not drive.done:
        loop.tick()
    truth = loop.world.truth()
    assert drive.failure is None
    assert math.dist((truth.x, truth.y), (12.0, 16.5)) < 0.3


def test_cancelled_it_stops():
    loop = Loop()
    loop.start("r-5303")
    loop.rest(40)
    assert loop.navigator.wheels.speed > 0.2
    loop.navigator.cancel()
    loop.rest(10)
    assert not loop.navigator.busy
    assert loop.world.reading.speed == pytest.approx(0.0, abs=1e-6)


def test_a_drive_that_is_cancelled_says_so():
    loop = Loop()
    drive = loop.start("r-5303")
    loop.rest(20)
    loop.navigator.cancel()
    assert drive.done
    report = loop.navigator.report(drive)
    assert report.outcome == drive.failure.reason == NavigationFailure.CANCELLED
    assert report.recoveries == 0
    arrived = loop.drive("r-5301")
    loop.navigator.cancel()
    assert arrived.failure is None


def test_news_of_a_better_way_turns_the_robot_round():
    loop = Loop(seed=1)
    goal = "r-5302"
    free = loop.navigator.planner.plan(loop.navigator.pose[:2], loop.navigator.floor.place(goal))
    spot = (free[2].to[0], free[2].to[1] + 0.5)
    loop.navigator.memory.blocked(spot, loop.sensors.time - 30.0)
    drive = loop.start(goal)
    planned = sum(step.metres for step in drive.steps)
    assert planned > 10.0 + sum(step.metres for step in free)
    loop.rest(20)
    loop.navigator.memory.forget_since(0.0)
    loop.rest(60)
    assert sum(step.metres for step in drive.steps) < planned - 10.0
    assert drive.troubles == []


def test_every_door_has_a_record():
    loop = Loop(seed=4)
    loop.drive("r-5303")
    assert loop.navigator.doors.doors["d-5303"] == DoorTally(passed=1, tries=1)
    loop.world.set_door("r-5303", is_open=False)
    loop.drive("r-5305")
    assert loop.navigator.doors.doors["d-5303"].shut == 1


def test_a_door_in_which_the_robot_got_stuck_is_recovered_from_or_given_up():
    log = DoorLog()
    log.try_door("d-1")
    log.get_stuck("d-1")
    log.get_stuck("d-1")
    log.try_door("d-1")
    log.get_through("d-1")
    assert log.doors["d-1"] == DoorTally(passed=1, tries=2, stuck=1, recovered=1)
    log.get_stuck("d-2")
    log.give_up()
    log.give_up()
    assert log.doors["d-2"] == DoorTally(stuck=1, given_up=1)
    copy = DoorLog()
    thaw(copy, json.loads(json.dumps(freeze(log))))
    assert copy.doors == log.doors


def test_bumped_in_a_door_it_backs_out_and_gets_through():
    loop = Loop(seed=4)
    bumped = iter([True])

    def push():
        drive = loop.navigator.driver.drive
        if drive and drive.in_door and loop.world.reading.speed > 0.15 and next(bumped, False):
            loop.sensors = loop.sensors.model_copy(update={"bump": 0b10})
            loop.navigator.step(loop.sensors)

    drive = loop.drive("r-5303", each=push)
    assert drive.failure is None
    assert loop.off("r-5303") < 0.25
    record = loop.navigator.doors.doors
    assert sum(one.stuck for one in record.values()) == 1
    assert sum(one.recovered for one in record.values()) == 1


def test_a_bump_stops_the_wheels_within_the_tick_and_backs_off():
    loop = Loop()
    loop.start("r-5303")
    loop.rest(40)
    touched = loop.sensors.model_copy(update={"bump": 0b1, "tick": 1000})
    assert loop.navigator.step(touched).speed <= 0.0
    before = loop.world.truth()
    loop.rest(10)
    after = loop.world.truth()
    back = (after.x - before.x) * math.cos(after.theta)
    back += (after.y - before.y) * math.sin(after.theta)
    assert back < 0.1
    assert len(loop.navigator.driver.drive.troubles) == 1


def test_wheels_that_do_not_turn_end_the_drive_as_no_progress():
    loop = Loop()
    loop.world.robot.battery = Battery(BatteryProfile(), charge=0.0)
    drive = loop.drive("r-5303", most=700)
    assert drive.failure.reason is NavigationFailure.NO_PROGRESS
    assert "battery" in drive.failure.text
    assert drive.metres < 0.1


def test_a_front_sonar_stuck_at_the_nearest_reading_blocks_the_way_and_is_no_broken_wheel():
    loop = Loop()
    make_fault(loop.world, SonarFault(number=0, state="stuck", metres=0.2))
    reflex, drive = Reflex(), loop.start("r-5303")
    for _ in range(4000):
        if drive.done:
            break
        wheels = loop.navigator.wheels
        reflex.sense(loop.world.robot.reading)
        loop.world.step(*reflex.allow(wheels.speed, wheels.turn))
        loop.sensors = loop.robot.sensors()
        loop.navigator.step(loop.sensors)
    assert drive.failure.reason is NavigationFailure.CORRIDOR_BLOCKED
    assert not any(isinstance(met, Disobeyed) for met in drive.troubles)


def test_wheels_that_are_held_for_a_while_only_delay_the_drive():
    loop = Loop()
    loop.world.robot.battery = Battery(BatteryProfile(), charge=0.0)
    loop.start("r-5303")
    loop.rest(250)
    loop.world.robot.battery = None
    drive = loop.navigator.driver.drive
    for _ in range(4000):
        if drive.done:
            break
        loop.tick()
    assert drive.failure is None
    assert isinstance(drive.troubles[0], Disobeyed)
    assert loop.off("r-5303") < 0.25


def test_told_its_place_it_goes_on_from_there():
    loop = Loop(seed=3)
    loop.drive("r-5303")
    navigator = loop.navigator
    x, y, theta = navigator.localizer.estimate.pose
    navigator.localizer.place((x, y + 3.6, theta))
    assert navigator.set_position("r-5303").room == "r-5303"
    assert loop.drive("r-5305").failure is None
    assert loop.off("r-5305") < 0.25
    with pytest.raises(UnknownRoomError):
        navigator.set_position("r-1")


def test_told_its_heading_as_well_it_believes_that_too():
    loop = Loop(seed=3)
    loop.rest(5)
    navigator = loop.navigator
    for theta, believed in ((1.0, 1.0), (-6.0, 2.0 * math.pi - 6.0)):
        assert navigator.set_position("r-5303", theta=theta).theta == pytest.approx(
            believed, abs=1e-3
        )


def test_displaced_unseen_it_notices_and_finds_itself():
    loop = Loop(seed=1)
    loop.drive("r-5303")
    x, y, theta = loop.navigator.localizer.estimate.pose
    loop.navigator.localizer.place((x, y + 1.0, theta))
    drive = loop.drive("r-5307", most=6000)
    assert drive.failure is None
    assert loop.off("r-5307") < 0.25


def test_nonsense_from_the_sonars_ends_as_lost_and_stands(monkeypatch):
    # Of its four minutes of patience the last are as the first.
    monkeypatch.setattr("navigate.driving._wander.ADVISED_SECONDS", 20.0)
    loop = Loop(seed=1)
    drive = loop.start("r-5303")
    random = np.random.default_rng(0)
    for tick in range(1, 1000):
        if drive.done:
            break
        noise = random.uniform(1.5, 6.0, 24).astype(np.float32)
        update = {"sonar": noise, "tick": tick, "time": tick * 0.1 + 1e9}
        loop.navigator.step(loop.sensors.model_copy(update=update))
    assert drive.done
    assert drive.failure.reason is NavigationFailure.LOST
    assert loop.navigator.wheels == STOP


def test_started_again_under_way_it_knows_roughly_where_it_is():
    loop = Loop(seed=6)
    loop.start("r-5303")
    loop.rest(100)
    kept = loop.navigator.snapshot()
    for _ in range(15):
        loop.world.step(0.2, 0.0)
    loop.navigator = Navigator(Floor(load_plan()), seed=11)
    loop.navigator.restore(kept)
    loop.rest(1)
    assert loop.astray() < 0.4
    assert loop.drive("r-5303").failure is None
    assert loop.off("r-5303") < 0.25


def test_odometry_set_anew_makes_it_doubt_but_not_jump():
    loop = Loop(seed=6)
    loop.drive("r-5303")
    before = loop.navigator.position()
    odom = np.array([90.0, 5.0, 1.0], dtype=np.float32)
    loop.navigator.step(loop.sensors.model_copy(update={"odom": odom, "tick": 99_999}))
    after = loop.navigator.position()
    assert math.dist((before.x, before.y), (after.x, after.y)) < 0.3
    assert after.deviation > before.deviation
