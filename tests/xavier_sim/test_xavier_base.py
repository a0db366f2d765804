"""The base: what its motors can do, wheels that slip, and what the encoders make of it."""

from __future__ import annotations

import math
import struct
from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from xavier_sim.body import BodyState, Odometry, Physics, Wheels, clip_command
from xavier_sim.body._base import next_velocities
from xavier_sim.floors import build_geometry, load_floor
from xavier_sim.profile import (
    HARD,
    MODERN,
    PHYSICS_STEP,
    XAVIER,
    BaseProfile,
    OdometryProfile,
)
from xavier_sim.world import World

PLAN = load_floor()
SYNCHRO, DIFFERENTIAL = XAVIER.base, MODERN.base
EXACT = OdometryProfile(
    **dict.fromkeys(
        ("scale_bias", "drift_bias", "turn_bias", "distance_noise", "drift_noise", "turn_noise"),
        0.0,
    )
)
speeds = st.floats(-0.7, 0.7)
turns = st.floats(-1.5, 1.5)


def wheels_of(base, velocities):
    speed, turn = velocities
    return speed - turn * base.track / 2, speed + turn * base.track / 2


@given(speeds, turns)
def test_synchro_drive_speeds_and_turns_independently(speed, turn):
    assert clip_command(SYNCHRO, speed, turn) == (speed, turn)
    straight = next_velocities(SYNCHRO, (0.0, 0.0), (speed, 0.0))
    turning = next_velocities(SYNCHRO, (0.0, 0.0), (speed, turn))
    assert straight[0] == turning[0]


@given(st.floats(-9, 9), st.floats(-9, 9))
def test_differential_drive_keeps_the_curvature_within_its_wheels(speed, turn):
    got = clip_command(DIFFERENTIAL, speed, turn)
    assert max(map(abs, wheels_of(DIFFERENTIAL, got))) <= DIFFERENTIAL.top_speed + 1e-9
    wanted = max(min(speed, 0.7), -0.7), max(min(turn, 1.5), -1.5)
    assert got[0] * wanted[1] == pytest.approx(got[1] * wanted[0], abs=1e-9)


@given(st.tuples(speeds, turns), st.tuples(speeds, turns))
def test_wheels_of_a_differential_drive_accelerate_no_faster_than_they_can(now, wanted):
    now, wanted = clip_command(DIFFERENTIAL, *now), clip_command(DIFFERENTIAL, *wanted)
    after = next_velocities(DIFFERENTIAL, now, wanted)
    for before, then in zip(
        wheels_of(DIFFERENTIAL, now), wheels_of(DIFFERENTIAL, after), strict=True
    ):
        assert abs(then - before) <= DIFFERENTIAL.braking * PHYSICS_STEP + 1e-9
    for _ in range(100):
        now = next_velocities(DIFFERENTIAL, now, wanted)
    assert now == pytest.approx(wanted, abs=1e-6)


def test_the_modern_robot_slows_down_to_turn():
    world = World(PLAN, profile=MODERN)
    world.place_robot(8.0, 12.0, 0.0)
    for _ in range(30):
        world.step(0.7, 0.0)
    assert world.reading.speed == pytest.approx(0.7)
    for _ in range(10):
        reading = world.step(0.7, 1.5)
    assert reading.speed < 0.5
    assert reading.turn_rate == pytest.approx(reading.speed * 1.5 / 0.7, abs=0.01)


@settings(max_examples=30)
@given(st.floats(0.0, 0.8), st.floats(-0.5, 0.5), speeds, turns)
def test_encoders_count_what_slipping_wheels_turn(slip, veer, speed, turn):
    wheels, moves, shaft = Wheels(SYNCHRO, slip, veer), (0.0, 0.0), (0.0, 0.0)
    for _ in range(20):
        moves = wheels.drive(moves, (speed, turn))
        shaft = next_velocities(SYNCHRO, shaft, (speed, turn))
        assert wheels.turned(*moves) == pytest.approx(shaft)
        assert abs(moves[0]) == pytest.approx(abs(shaft[0]) * (1.0 - slip))


def test_a_slipping_wheel_slows_the_robot_and_turns_it_and_the_odometry_does_not_notice():
    world = World(PLAN, profile=XAVIER.model_copy(update={"odometry": EXACT}))
    world.place_robot(7.57, 20.0, math.pi / 2)
    world.robot.wheels = Wheels(SYNCHRO, 0.5, 0.05)
    for _ in range(100):
        reading = world.step(0.5, 0.0)
    truth = world.truth()
    assert reading.speed == pytest.approx(0.5)
    assert reading.odom[0] == pytest.approx(2 * truth.metres, rel=0.01)
    assert reading.odom[1:] == pytest.approx([0.0, 0.0], abs=0.01)
    assert truth.theta - math.pi / 2 == pytest.approx(0.05 * reading.odom[0], rel=0.02)


def test_wheels_slip_by_chance_over_long_ways():
    def end(slips_per_metre, seed):
        odometry = Odometry(EXACT.model_copy(update={"slips_per_metre": slips_per_metre}), seed)
        for _ in range(2000):
            odometry.move(0.05, 0.0)
        return odometry.pose()

    assert end(0.0, 1) == pytest.approx([100.0, 0.0, 0.0], abs=1e-3)
    off = np.array([end(HARD.odometry.slips_per_metre, seed) for seed in range(20)])
    assert 0.02 < np.abs(off[:, 2]).mean() < 0.3
    assert not np.array_equal(off[0], off[1])
    assert np.array_equal(off[3], end(HARD.odometry.slips_per_metre, 3))


def test_slips_by_chance_leave_the_other_noise_as_it_is():
    """Each kind of error has a stream of its own."""
    slippery = XAVIER.odometry.model_copy(update={"slips_per_metre": 0.02})
    plain, other = Odometry(XAVIER.odometry, 5), Odometry(slippery, 5)
    for _ in range(40):
        plain.move(0.05, 0.01)
        other.move(0.05, 0.01)
    assert np.array_equal(plain.pose(), other.pose())


def test_a_track_is_some_width():
    with pytest.raises(ValueError, match="track"):
        BaseProfile(track=0.0)


@given(st.lists(st.tuples(st.floats(-0.6, 0.6), st.floats(-1.5, 1.5)), max_size=20))
@settings(max_examples=20, deadline=None)
def test_the_state_is_what_pymunk_says_whether_it_was_read_or_pushed(pushes):
    physics = Physics(build_geometry(PLAN))
    robot = physics.add_robot(XAVIER.base, BodyState(PLAN.start.x, PLAN.start.y, 2.0))
    for speed, turn_rate in [*pushes, (-0.0, -0.0)]:
        robot.push(speed, turn_rate)
        physics.step()
        body = robot.shape.body
        read = (*body.position, body.angle, *body.velocity, body.angular_velocity)
        assert struct.pack("6d", *read) == struct.pack("6d", *astuple(robot.state))
