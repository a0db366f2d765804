from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from navigate_rings import ALL, TRUE, ring

from navigate.body import BEARINGS, RING_RADIUS, Motion, motion_between, moved, plausible, wrap
from navigate.driving import View
from navigate.driving._doorframe import DoorFrame
from navigate.maps import Floor, load_plan
from navigate.position import ExpectedRanges, ParticleFilter
from navigate.position._expected import REACH

EXPECTED = ExpectedRanges(TRUE)
poses = st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-3.1, 3.1))


@given(poses, poses)
def test_motion_takes_one_pose_to_the_other(before, now):
    there = moved(before, motion_between(before, now))
    np.testing.assert_allclose(there[:2], now[:2], atol=1e-9)
    assert abs(wrap(there[2] - now[2])) < 1e-9


def test_a_jump_of_odometry_is_no_motion():
    assert plausible(Motion(0.06, 0.0, 0.1), 0.1)
    assert plausible(Motion(3.0, 0.0, 0.0), 5.0)
    assert not plausible(Motion(3.0, 0.0, 0.0), 0.1)


def test_expected_ranges_are_near_what_sonars_read():
    random = np.random.default_rng(1)
    off = []
    for _ in range(30):
        x, y, theta = random.uniform(6.9, 8.2), random.uniform(20, 34), random.uniform(-3, 3)
        look = theta + BEARINGS
        opened, shut = EXPECTED.at(
            x + RING_RADIUS * np.cos(look), y + RING_RADIUS * np.sin(look), look
        )
        assert (shut <= opened).all()
        assert (opened <= REACH).all()
        off.append(np.abs(opened - np.minimum(ring(x, y, theta), REACH)))
    assert np.median(off) < 0.06
    assert np.mean(np.array(off) < 0.2) > 0.8


def test_the_table_fills_only_where_it_is_asked():
    table = ExpectedRanges(TRUE)
    assert table.filled == 0
    first = table.at(np.full(1, 7.5), np.full(1, 20.0), np.zeros(1))
    assert table.filled == 1
    assert table.at(np.full(1, 7.5), np.full(1, 20.0), np.zeros(1)) == first
    assert table.filled == 1
    assert table.at(np.full(1, -99.0), np.full(1, 999.0), np.zeros(1))[0] <= REACH


def test_the_start_is_known():
    here = ParticleFilter(TRUE).estimate
    assert math.dist((here.x, here.y), (TRUE.plan.start.x, TRUE.plan.start.y)) < 0.05
    assert here.deviation < 0.15


@pytest.mark.parametrize("drift", [-0.01, 0.01])
@pytest.mark.parametrize("scale", [0.97, 1.03])
def test_sonars_hold_the_estimate_while_odometry_drifts(drift, scale):
    estimator = ParticleFilter(TRUE, seed=1)
    x, y, theta = 7.57, 20.0, math.pi / 2
    estimator.place((x, y, theta))
    for step in range(250):
        y += 0.05
        estimator.move(Motion(0.05 * scale, 0.0, 0.05 * drift))
        estimator.sense(ring(x, y, theta), 0x111111 << (step % 4), still=False)
    here = estimator.estimate
    assert math.dist((here.x, here.y), (x, y)) < 0.35
    assert abs(wrap(here.theta - theta)) < 0.1
    assert not estimator.lost
    assert here.agreement > 0.6


def test_the_same_seed_and_readings_give_the_same_estimate():
    def run():
        estimator = ParticleFilter(TRUE, seed=3)
        for step in range(30):
            estimator.move(Motion(0.05, 0.0, 0.01))
            estimator.sense(ring(7.57, 12.0 + 0.05 * step, 1.57), ALL, still=False)
        return estimator.estimate

    assert run() == run()


def test_standing_still_does_not_make_it_surer_and_surer():
    estimator = ParticleFilter(TRUE, seed=1)
    estimator.place((7.57, 25.0, 1.57), spread=0.1)
    readings = ring(7.57, 25.0, 1.57)
    for step in range(400):
        estimator.sense(readings, 0x111111 << (step % 4), still=True)
    assert estimator.estimate.deviation > 0.01


def test_it_notices_that_it_is_lost_and_finds_itself():
    estimator = ParticleFilter(TRUE, seed=2)
    estimator.place((7.57, 12.0, 0.0))
    truth = (9.9, 10.2, 0.1)
    readings = ring(*truth)
    for _ in range(400):
        estimator.move(Motion(0.001, 0.0, 0.0))
        estimator.sense(readings, ALL, still=False)
        if estimator.lost:
            break
    assert estimator.lost
    for _ in range(5):
        if estimator.lost:
            estimator.recover(readings, radius=4.0)
    here = estimator.estimate
    assert math.dist((here.x, here.y), truth[:2]) < 0.3
    assert not estimator.lost


def test_echoes_from_nowhere_do_not_make_it_lost():
    random = np.random.default_rng(5)
    estimator = ParticleFilter(TRUE, seed=5)
    x, y, theta = 7.57, 20.0, math.pi / 2
    estimator.place((x, y, theta))
    for step in range(200):
        y += 0.05
        readings = ring(x, y, theta)
        readings[random.random(24) < 0.1] = np.inf
        readings[random.random(24) < 0.05] = random.uniform(0.2, 6.5)
        estimator.move(Motion(0.05, 0.0, 0.0))
        estimator.sense(readings, 0x111111 << (step % 4), still=False)
    assert not estimator.lost
    assert abs(estimator.estimate.x - x) < 0.15


def test_jambs_tell_the_middle_of_a_door_better_than_map_and_position():
    door = Floor(load_plan()).doors["d-5303"]
    true_middle = TRUE.doors["d-5303"].centre
    for error in (-0.12, 0.0, 0.12):
        x, y = true_middle[0] + 1.2, true_middle[1]
        frame = None
        while x > true_middle[0] + 0.3:
            odom = (x, y, math.pi)
            view = View(
                time=0.0,
                pose=(x, y + error, math.pi),
                odom=odom,
                ranges=ring(*odom),
                fresh=ALL,
                bump=0,
                echoes=np.zeros((0, 2)),
            )
            frame = frame or DoorFrame(door, -1.0, view)
            frame.measure(view)
            x -= 0.05
        _, left, turned = frame.locate((x, y, math.pi))
        assert abs(left) < 0.04
        assert abs(turned) < 0.01
        assert frame.doubt < 0.05


@pytest.mark.parametrize("askew", [math.radians(-6.0), 0.0, math.radians(6.0)])
def test_jambs_tell_which_way_the_robot_looks_whatever_it_believes(askew):
    door, (middle, y) = Floor(load_plan()).doors["d-5303"], TRUE.doors["d-5303"].centre
    frame = None
    for x in np.arange(middle + 1.2, middle - 0.7, -0.05).tolist():
        odom = (x, y, math.pi)
        echoes, pose = np.zeros((0, 2)), (x, y, wrap(math.pi + askew))
        view = View(0.0, pose, odom, ring(*odom), ALL, 0, echoes)
        frame = frame or DoorFrame(door, -1.0, view)
        frame.measure(view)
    look = frame.orient(odom)
    off = abs(wrap(look.theta - math.pi))
    assert off < 2.5 * look.doubt
    assert off < math.radians(2.0)


def test_where_no_jamb_is_heard_nothing_tells_which_way_the_robot_looks():
    door, frame = TRUE.doors["d-5303"], None
    for x in np.arange(1.2, -0.7, -0.05).tolist():
        odom = (door.centre[0] + x, door.centre[1], math.pi)
        view = View(0.0, odom, odom, np.full(24, np.inf), ALL, 0, np.zeros((0, 2)))
        frame = frame or DoorFrame(door, -1.0, view)
        frame.measure(view)
    assert frame.orient(odom) is None
