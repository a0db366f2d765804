"""The POMDP as a localizer: tracking within cells, getting lost, being found."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from navigate_rings import ALL, TRUE, ring

from navigate.body import Motion, wrap
from navigate.freezing import freeze, thaw
from navigate.navigator import Navigator
from navigate.position import PomdpLocalizer
from navigate.position._beacons import BeaconTracker
from navigate.position._expected import ExpectedRanges
from navigate.position._pomdp import MOST_TICKS
from navigate.position._readings import MOUNTS, Readings, seen_from
from navigate.position._search import Search
from navigate.position._walls_met import nearest_points
from xavier_sim.messages import Sensors

NORTH = math.pi / 2
LOCALIZER = PomdpLocalizer(TRUE)
FRESH = freeze(LOCALIZER)


@pytest.fixture
def localizer():
    """One that was just made; making it anew takes longer than most tests."""
    thaw(LOCALIZER, FRESH)
    return LOCALIZER


def nearest(lines, direction):
    """What one sonar at the origin meets of some walls."""
    lines = np.array(lines)
    way = lines[:, 2:] - lines[:, :2]
    ends = np.concatenate([lines[:, :2], way]).T
    looking = np.array([[0.0, 0.0, direction]])
    return nearest_points(ends, (way**2).sum(axis=1), len(lines), looking)[0]


def tracker_at(pose, spread=0.1, turn_spread=0.1):
    tracker = BeaconTracker(TRUE)
    tracker.place(pose, spread=spread, turn_spread=turn_spread)
    return tracker


def drive_north(localizer, x, y, metres, *, step=0.05):
    """Drive a localizer up a corridor, with perfect odometry and sonars."""
    for number in range(round(metres / step)):
        y += step
        localizer.move(Motion(step, 0.0, 0.0))
        localizer.sense(ring(x, y, NORTH), 0x111111 << (number % 4), still=False)
    return y


def test_the_nearest_point_of_a_wall_is_met_at_right_angles():
    met = nearest([[2.0, -5.0, 2.0, 5.0], [-1.0, 0.0, -1.0, 9.0]], 0.0)
    assert met.distance[0] == pytest.approx(2.0)
    assert (met.ahead[0], met.aside[0]) == pytest.approx((2.0, 0.0))
    assert met.sharp[0]


def test_the_nearest_point_of_a_wall_is_its_end():
    met = nearest([[2.0, -5.0, 2.0, 5.0], [1.0, 0.1, 1.0, 3.0]], 0.0)
    assert met.distance[0] == pytest.approx(math.hypot(1.0, 0.1))
    assert met.sharp[0]


def test_a_wall_met_askance_is_no_beacon():
    met = nearest([[2.0, -1.0, 2.0, 5.0]], 0.5)
    assert met.distance[0] == pytest.approx(2.0 / math.cos(0.5 - math.radians(11.25)), abs=1e-6)
    assert not met.sharp[0]


def test_a_wall_behind_is_not_met():
    assert math.isinf(nearest([[-2.0, -1.0, -2.0, 5.0]], 0.0).distance[0])


def test_readings_of_some_ticks_ago_are_seen_from_where_the_robot_is_now():
    readings = Readings()
    readings.add((1.0, 2.0, NORTH), [0, 6], np.full(24, 1.5), np.empty(0))
    readings.add((1.0, 3.0, NORTH), [1], np.full(24, 1.5), np.empty(0))
    seen = seen_from((1.0, 3.0, NORTH), readings.latest())
    assert seen[0] == pytest.approx(MOUNTS[0] - (1.0, 0.0, 0.0))
    assert seen[1] == pytest.approx(MOUNTS[6] - (1.0, 0.0, 0.0))
    assert seen[2] == pytest.approx(MOUNTS[1])
    assert len(readings.latest().sonars) == 0
    assert readings.count == 3


def test_walls_beside_tell_how_far_off_the_middle_the_robot_is():
    tracker = tracker_at((7.57 + 0.15, 20.5, NORTH))
    before = tracker.covariance[0, 0]
    for _ in range(10):
        tracker.sense(MOUNTS, ring(7.57, 20.5, NORTH), still=False)
    assert abs(tracker.pose[0] - 7.57) < 0.05
    assert tracker.covariance[0, 0] < 0.2 * before


@pytest.mark.parametrize("drift", [-0.02, 0.02])
@pytest.mark.parametrize("scale", [0.95, 1.1])
def test_beacons_hold_the_pose_while_odometry_drifts(drift, scale):
    tracker = tracker_at((7.57, 20.0, NORTH), 0.05, 0.03)
    y = 20.0
    for _ in range(120):
        y += 0.2
        tracker.move(Motion(0.2 * scale, 0.0, 0.2 * drift))
        readings = ring(7.57, y, NORTH)
        heard = np.flatnonzero(np.isfinite(readings))
        tracker.sense(MOUNTS[heard], readings[heard], still=False)
    assert math.dist(tracker.pose[:2], (7.57, y)) < 0.2
    assert abs(wrap(tracker.pose[2] - NORTH)) < 0.05
    assert tracker.errs[:2] == pytest.approx((drift, 1.0 - 1.0 / scale), abs=0.01)


def test_what_is_learnt_of_the_wheels_stays_known_when_the_robot_is_told_where_it_is():
    tracker = tracker_at((7.57, 20.0, NORTH), 0.05, 0.03)
    for step in range(1, 80):
        tracker.move(Motion(0.22, 0.0, 0.004))
        readings = ring(7.57, 20.0 + 0.2 * step, NORTH)
        heard = np.flatnonzero(np.isfinite(readings))
        tracker.sense(MOUNTS[heard], readings[heard], still=False)
    learnt = tracker.errs
    tracker.place((18.0, 39.6, 0.0), spread=0.1, turn_spread=0.1)
    assert tracker.errs == learnt
    assert learnt[1] == pytest.approx(1.0 - 1.0 / 1.1, abs=0.02)


def test_standing_still_does_not_make_the_tracker_surer_and_surer():
    tracker = tracker_at((7.57, 25.0, NORTH))
    readings = ring(7.57, 25.0, NORTH)
    for _ in range(400):
        tracker.sense(MOUNTS[::4], readings[::4], still=True)
    assert math.sqrt(tracker.covariance[1, 1]) > 0.01


def test_cells_and_tracker_agree_along_a_corridor(localizer):
    localizer.place((7.57, 20.0, NORTH))
    y = drive_north(localizer, 7.57, 20.0, 12.0)
    assert math.dist(localizer.estimate.pose[:2], (7.57, y)) < 0.15
    assert localizer.markov.near((7.57, y), within=1.6) > 0.6
    assert localizer.mass_near(7.57, y, within=0.6) > 0.5
    assert localizer.mass_near(7.57, y - 10.8, within=0.6) < 0.05
    assert not localizer.lost


def lost_at(localizer, truth):
    """Let it believe to be elsewhere until readings contradict that; then look for a ring."""
    localizer.place((7.57, 33.0, NORTH))
    readings = ring(*truth)
    while not localizer.lost:
        localizer.sense(readings, ALL, still=False)
    for _ in range(2):
        localizer.recover(readings, radius=6.0)


def drive_on(localizer, truth, metres):
    """Drive straight on, hearing what is to be heard, and look for a ring at the end."""
    x, y, theta = truth
    for _ in range(round(metres / 0.05)):
        x, y = x + 0.05 * math.cos(theta), y + 0.05 * math.sin(theta)
        localizer.move(Motion(0.05, 0.0, 0.0))
        localizer.sense(ring(x, y, theta), ALL, still=False)
    localizer.recover(ring(x, y, theta), radius=1.0)
    for _ in range(130):
        localizer.sense(ring(x, y, theta), 0, still=True)
    return (x, y, theta)


def test_readings_that_contradict_make_it_lost_and_rings_of_two_places_find_it_again(localizer):
    truth = (8.6, 37.2, 0.1)
    lost_at(localizer, truth)
    assert localizer.lost
    assert not localizer.supposes
    for _ in range(130):
        localizer.sense(ring(*truth), 0, still=True)
    assert math.dist(localizer.estimate.pose[:2], truth[:2]) < 0.4
    assert localizer.lost
    assert localizer.supposes
    now = drive_on(localizer, truth, 2.5)
    assert math.dist(localizer.estimate.pose[:2], now[:2]) < 0.4
    assert not localizer.lost
    assert not localizer.supposes


def test_who_was_lost_is_so_until_much_agrees_again(localizer):
    localizer.place((7.57, 33.0, NORTH))
    while not localizer.lost:
        localizer.sense(ring(8.6, 37.2, 0.1), ALL, still=False)
    right = ring(7.57, 33.0, NORTH)
    while localizer.agreement < 0.6:
        localizer.sense(right, ALL, still=False)
    assert localizer.lost
    while localizer.lost:
        localizer.sense(right, ALL, still=False)
    assert localizer.agreement >= 0.7


def test_a_robot_that_may_be_anywhere_knows_that_it_is_lost(localizer):
    localizer.forget()
    assert localizer.lost
    assert localizer.belief().entropy > 11.0


def way(localizer, goal):
    """Which way to go, when that has been worked out."""
    for _ in range(40):
        if (angle := localizer.way_to(goal)) is not None:
            return angle
    return None


def test_it_advises_on_the_way(localizer):
    goal = TRUE.place("r-5321")
    localizer.place((7.57, 20.0, NORTH + 0.2))
    assert way(localizer, goal) == pytest.approx(-0.2)
    localizer.place((7.57, 20.0, -NORTH))
    assert abs(way(localizer, goal)) == pytest.approx(math.pi / 2)
    localizer.place((*goal, math.pi))
    assert way(localizer, goal) is None


def test_its_state_is_kept_and_gone_on_with_bit_for_bit(localizer):
    localizer.place((7.57, 20.0, NORTH))
    y = drive_north(localizer, 7.57, 20.0, 3.0)
    again = PomdpLocalizer(TRUE)
    thaw(again, json.loads(json.dumps(freeze(localizer))))
    for one in (localizer, again):
        drive_north(one, 7.57, y, 2.0)
    assert again.estimate == localizer.estimate
    assert (again.markov.chances == localizer.markov.chances).all()


def found(cells, readings):
    """What a search among cells that are as probable each comes to."""
    search = Search(ExpectedRanges(TRUE))
    search.begin(np.array(cells), np.full(len(cells), 1.0 / len(cells)), readings)
    result = None
    while search.busy:
        result = search.go_on()
    return result


def test_a_search_tells_how_far_the_best_pose_stands_out():
    readings = ring(8.6, 37.2, 0.1)
    crossing, corridor, alike = (8.5, 37.2, 0.0), (7.57, 48.0, 0.0), (8.5, 58.2, 0.0)
    once = found([crossing, corridor], readings)
    assert math.dist(once.pose[:2], (8.6, 37.2)) < 0.2
    assert once.share > 0.8
    assert found([crossing, alike], readings).share < once.share
    assert found([crossing, corridor], np.full(24, np.inf)) is None


def test_a_search_goes_on_a_few_cells_at_a_time_and_can_be_kept_meanwhile():
    cells = np.array([(7.57, 20.0 + number / 2, NORTH) for number in range(80)])
    readings = ring(7.57, 30.0, NORTH)
    one, other = Search(ExpectedRanges(TRUE)), Search(ExpectedRanges(TRUE))
    one.begin(cells, np.full(80, 1.0 / 80), readings)
    assert one.go_on() is None
    assert one.busy
    thaw(other, json.loads(json.dumps(freeze(one))))
    ends = []
    for search in (one, other):
        while search.busy:
            end = search.go_on()
        ends.append(end)
    assert ends[0][:2] == ends[1][:2]
    assert (ends[0].fits == ends[1].fits).all()
    assert ends[0].fits.shape == (80,)
    assert abs(int(ends[0].fits.argmax()) - 20) <= 1


def test_a_robot_that_moved_while_it_was_looked_for_is_found_where_it_is_now(localizer):
    truth = (8.6, 37.2, 0.1)
    lost_at(localizer, truth)
    for _ in range(10):
        localizer.move(Motion(0.05, 0.0, 0.0))
    now = (truth[0] + 0.5 * math.cos(0.1), truth[1] + 0.5 * math.sin(0.1), 0.1)
    for _ in range(60):
        localizer.sense(ring(*now), 0, still=True)
    assert math.dist(localizer.estimate.pose[:2], now[:2]) < 0.4
    assert localizer.supposes


def test_a_pose_that_is_doubted_is_supposed_no_more(localizer):
    truth = (8.6, 37.2, 0.1)
    lost_at(localizer, truth)
    for _ in range(130):
        localizer.sense(ring(*truth), 0, still=True)
    before = localizer.markov.near(truth[:2], within=1.6)
    localizer.doubt()
    assert not localizer.supposes
    assert localizer.lost
    assert localizer.markov.near(truth[:2], within=1.6) < before
    assert abs(localizer.markov.chances.sum() - 1.0) < 1e-9


def test_suspects_are_what_is_believed_and_what_is_near(localizer):
    belief = localizer.markov
    belief.know((7.57, 60.0, NORTH))
    states, mass = belief.suspects(belief.chances, (7.57, 20.0), within=2.0, astray=0.3, share=0.95)
    poses = belief.poses(states)
    far = poses[:, 1] > 50.0
    assert mass[far].sum() > 0.5
    assert (np.hypot(*(poses[~far, :2] - (7.57, 20.0)).T) <= 2.0).any()
    assert 0.95 <= mass.sum() < 0.97


def test_a_verified_arrival_puts_all_belief_at_the_room(localizer):
    localizer.forget()
    navigator = Navigator(TRUE, localizer=localizer)
    x, y = TRUE.place("r-5303")
    for tick in range(3):
        navigator.step(standing(tick, ring(x, y, math.pi)))
    assert navigator.localizer.lost
    position = navigator.set_position("r-5303")
    assert position.room == "r-5303"
    assert position.confidence > 0.8
    assert not navigator.localizer.lost


def standing(tick, ranges):
    return Sensors(
        tick=tick,
        time=0.1 * tick,
        period=0.1,
        lockstep=True,
        sonar=ranges.astype(np.float32),
        sonar_fresh=ALL,
        odom=np.zeros(3, dtype=np.float32),
        speed=0.0,
        turn_rate=0.0,
        bump=0,
    )


def test_a_robot_that_hears_nothing_new_keeps_nothing_of_it(localizer):
    beams = np.full(31, 2.0)
    for _ in range(2 * MOST_TICKS + 7):
        localizer.sense(np.full(24, np.inf), 0, still=True, striper=beams)
    assert localizer._readings.ticks == 7


def test_of_its_way_a_robot_that_is_not_lost_keeps_nothing(localizer):
    localizer.place((7.57, 20.0, NORTH))
    kept = freeze(localizer._rings)
    drive_north(localizer, 7.57, 20.0, 9.0)
    assert not localizer.lost
    assert freeze(localizer._rings) == kept
