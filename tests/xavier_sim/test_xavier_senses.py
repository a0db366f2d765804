"""Sonars, striper and lidar: what they see, how they err, and the same again."""

from __future__ import annotations

import json
import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from tca_bus._frames import decode_frame, encode_frame
from tca_bus._types import array_fields
from xavier_sim.cli._worlds import WorldFlags, open_world
from xavier_sim.floors import Geometry
from xavier_sim.messages import (
    LIDAR_BEAMS,
    SONAR_COUNT,
    STRIPER_BEAMS,
    LaserOffset,
    ProfileName,
    Sensors,
    SonarFault,
)
from xavier_sim.profile import HARD, MODERN, PROFILES, XAVIER, RobotProfile, SonarProfile
from xavier_sim.sensors import NoSensorError, Senses
from xavier_sim.sensors._crosstalk import Crosstalk

EAST = (0.0, 0.0, 0.0)
LEFT, RIGHT = slice(STRIPER_BEAMS // 2 + 1, None), slice(STRIPER_BEAMS // 2)
AHEAD = STRIPER_BEAMS // 2


def walls(*rows):
    """A geometry of walls and one door far away."""
    away = np.array([[90.0, 0.0, 91.0, 0.0]])
    return Geometry(np.array(rows, dtype=float).reshape(-1, 4), away, ("d-1",), ("r-1",))


def wall_ahead(distance):
    return walls((distance, -50.0, distance, 50.0))


CELL = walls((3, -2, 3, 2), (-3, -2, -3, 2), (-3, 2, 3, 2), (-3, -2, 3, -2))


def readings(profile, geometry, ticks, pose=EAST, seed=1, **about):
    senses = Senses(profile, geometry, seed)
    return [senses.sense(tick, pose, **about) for tick in range(ticks)]


def with_sonar(**fields):
    return RobotProfile(sonar=SonarProfile(**{"outliers": 0.0, "phases": 1, **fields}))


@pytest.mark.parametrize("name", sorted(PROFILES))
def test_a_robot_senses_what_its_profile_has(name):
    profile = PROFILES[name]
    sensed = readings(profile, CELL, 8)[-1]
    assert len(sensed.sonar) == SONAR_COUNT
    assert len(sensed.striper) == (STRIPER_BEAMS if profile.striper else 0)
    assert len(sensed.lidar) == (LIDAR_BEAMS if profile.lidar else 0)
    assert {sensed.sonar.dtype, sensed.striper.dtype, sensed.lidar.dtype} == {np.dtype(np.float32)}


@settings(max_examples=15, deadline=None)
@given(st.sampled_from(sorted(PROFILES)), st.integers(0, 40), st.integers(0, 1000))
def test_restored_senses_go_on_bit_for_bit(name, ticks, seed):
    straight, resumed = (Senses(PROFILES[name], CELL, own) for own in (seed, seed + 1))
    for tick in range(ticks):
        straight.sense(tick, (0.01 * tick, 0.0, 0.02 * tick))
    resumed.restore(json.loads(json.dumps(straight.snapshot())))
    assert sensed_bytes(resumed.sensed(0)) == sensed_bytes(straight.sensed(0))
    for tick in range(ticks, ticks + 10):
        mine, theirs = (one.sense(tick, (1.0, 0.3, 0.1 * tick)) for one in (straight, resumed))
        assert sensed_bytes(mine) == sensed_bytes(theirs)


def sensed_bytes(sensed):
    arrays = sensed.sonar, sensed.striper, sensed.lidar
    return sensed.sonar_fresh, *(array.tobytes() for array in arrays)


def test_what_a_snapshot_does_not_know_stays_as_it_is():
    senses = Senses(HARD, CELL, 1)
    senses.switch_on(EAST)
    before = senses.sensed(0)
    old = senses.snapshot()
    del old["striper"], old["sonar"]["crosstalk"]
    senses.restore(old)
    assert sensed_bytes(senses.sensed(0)) == sensed_bytes(before)


@pytest.mark.parametrize("name", sorted(PROFILES))
def test_senses_do_not_depend_on_the_caster(name):
    pytest.importorskip("numba")
    people = np.array([[1.5, 0.2, 0.25], [-1.0, -1.2, 0.25]])
    logs = []
    for rays in ("numpy", "numba"):
        senses = Senses(PROFILES[name], CELL, 3, rays=rays)
        poses = [(0.02 * tick, -0.01 * tick, 0.1 * tick) for tick in range(60)]
        log = [senses.sense(tick, pose, circles=people) for tick, pose in enumerate(poses)]
        logs.append([sensed_bytes(sensed) for sensed in log])
    assert logs[0] == logs[1]


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"phases": 0}, "phases"),
        ({"rays": 0}, "rays"),
        ({"crosstalk": 1.5}, "crosstalk"),
        ({"farthest": math.inf}, "farthest"),
        ({"specular_from": 1.0, "specular_to": 1.0}, "specular_to: expected more than"),
    ],
)
def test_sonars_that_cannot_be_are_refused(fields, says):
    with pytest.raises(ValidationError, match=says):
        SonarProfile(**fields)


def test_a_robot_needs_something_that_looks_round():
    with pytest.raises(ValidationError, match="expected sonars where there is no lidar"):
        RobotProfile(sonar=None)


@pytest.mark.parametrize("profile", [XAVIER, HARD, MODERN], ids=["xavier", "hard", "modern"])
def test_who_stands_about_is_seen(profile):
    person = np.array([[1.4, 0.0, 0.25]])
    alone, met = (readings(profile, CELL, 60, circles=c) for c in (None, person))
    for log, expected in ((alone, 2.75), (met, 0.9)):
        assert np.median([sensed.sonar[0] for sensed in log]) == pytest.approx(expected, abs=0.06)


def test_the_striper_errs_with_the_square_of_the_range():
    spreads = []
    for distance in (0.8, 1.6, 2.4):
        ahead = np.array([one.striper[AHEAD] for one in readings(HARD, wall_ahead(distance), 600)])
        seen = ahead[np.isfinite(ahead)]
        assert seen.mean() == pytest.approx(distance - 0.25, abs=0.01)
        spreads.append(seen.std() - HARD.striper.noise)
    squares = [(distance - 0.25) ** 2 for distance in (0.8, 1.6, 2.4)]
    ratios = [spread / square for spread, square in zip(spreads, squares, strict=True)]
    assert ratios == pytest.approx([HARD.striper.noise_square] * 3, rel=0.25)


def test_the_striper_loses_more_beams_from_farther():
    lost = []
    for distance in (0.8, 2.9):
        log = readings(HARD, wall_ahead(distance), 400)
        lost.append(np.mean([math.isinf(one.striper[AHEAD]) for one in log]))
    assert lost[0] == pytest.approx(0.02, abs=0.02)
    assert lost[1] == pytest.approx(0.08, abs=0.04)


@pytest.mark.parametrize("distance", [0.4, 3.6])
def test_the_striper_does_not_see_what_is_too_near_or_too_far(distance):
    assert np.isinf([one.striper for one in readings(HARD, wall_ahead(distance), 20)]).all()


def test_the_striper_looks_from_the_right_to_the_left():
    left = walls((1.0, 0.05, 1.0, 5.0))
    seen = np.isfinite([one.striper for one in readings(HARD, left, 50)]).mean(axis=0)
    assert seen[LEFT][4:].min() > 0.8
    assert not seen[RIGHT].any()


def test_a_striper_sees_no_wall_that_it_looks_along():
    along = walls((-5.0, -0.1, 5.0, -0.1))
    seen = np.isfinite([one.striper for one in readings(HARD, along, 40)]).mean(axis=0)
    assert seen[:5].min() > 0.8
    assert not seen[6:].any()


def test_the_lidar_looks_all_round():
    seen = np.median([one.lidar for one in readings(MODERN, CELL, 200)], axis=0)
    bearings = np.radians(np.arange(LIDAR_BEAMS) * 2 - 179)
    with np.errstate(divide="ignore"):
        true = np.minimum(3 / np.abs(np.cos(bearings)), 2 / np.abs(np.sin(bearings)))
    assert seen == pytest.approx(true, abs=0.02)


def test_a_lidar_stands_in_for_the_ring():
    sonar = np.median([one.sonar for one in readings(MODERN, CELL, 100)], axis=0)
    assert sonar[[0, 6, 12, 18]] == pytest.approx([2.75, 1.75, 2.75, 1.75], abs=0.03)
    assert {one.sonar_fresh for one in readings(MODERN, CELL, 3)} == {(1 << SONAR_COUNT) - 1}


def test_a_neighbour_is_heard_from_half_the_way_of_its_ping():
    crosstalk, mounts = Crosstalk(1.0, seed=1), np.array([[0.0, 0.0], [0.0, 1.0]])
    draw = crosstalk.draw(2)
    assert draw is not None
    heard = crosstalk.disturb(draw, mounts, np.zeros(2), [2.0, math.inf])
    assert heard == pytest.approx([2.0, (2.0 + math.hypot(2.0, 1.0)) / 2])


def test_crosstalk_makes_echoes_where_nothing_is():
    open_ahead = walls((-50, 1.4, 50, 1.4), (-50, -1.4, 50, -1.4))
    counts = []
    for share in (0.0, 0.3):
        profile = with_sonar(crosstalk=share, phases=4)
        log = [one.sonar[0] for one in readings(profile, open_ahead, 400)]
        counts.append(np.isfinite(log).mean())
    assert counts[0] == 0.0
    assert 0.1 < counts[1] < 0.4


def test_a_smooth_wall_takes_the_whole_cone_away():
    """Facing a wall at 45 degrees a cone is lost as one, or not at all."""
    slanting = walls((-50.0, -50.0 + 2.0, 50.0, 50.0 + 2.0))
    share = {}
    for whole in (False, True):
        profile = with_sonar(
            specular_whole=whole, specular_from=math.radians(20), specular_to=math.radians(40)
        )
        log = np.array([one.sonar[0] for one in readings(profile, slanting, 400, (0.0, 4.0, 0.0))])
        share[whole] = np.isinf(log).mean()
    assert share[False] < 0.7
    assert share[True] > share[False] + 0.15


def test_the_hard_ring_takes_half_a_second_to_go_round():
    log = readings(HARD, CELL, 5)
    assert sum(one.sonar_fresh for one in log) == (1 << SONAR_COUNT) - 1


def opened(**flags):
    world = WorldFlags(seed=1, rays="numpy", **flags)
    return open_world(world, speed="max", data=None, epoch="1997-06-02T09:00")


@pytest.mark.parametrize("name", get_args(ProfileName))
def test_a_flag_names_the_robot_and_its_message_tells_all_that_it_senses(name):
    state, _ = opened(profile=name)
    sent = state.sensors()
    frame = encode_frame(sent, array_fields(Sensors))
    got = Sensors.model_validate(decode_frame(frame, Sensors.wire_name))
    reading = state.world.reading
    for field in ("sonar", "striper", "lidar"):
        assert getattr(got, field).tobytes() == getattr(reading, field).tobytes()
    assert state.world.profile == PROFILES[name]


def test_what_an_older_robot_says_is_understood():
    state, _ = opened()
    old = state.sensors().model_dump(exclude={"striper", "lidar"})
    got = Sensors.model_validate(old)
    assert (len(got.striper), len(got.lidar)) == (0, 0)


def test_faulty_sonars_read_what_they_read_and_the_others_what_they_would():
    sound, faulty = Senses(XAVIER, CELL, 1), Senses(XAVIER, CELL, 1)
    for senses in (sound, faulty):
        senses.switch_on(EAST)
    faulty.stick_sonar(0, math.inf)
    faulty.stick_sonar(4, 0.8)
    faulty.stick_sonar(9)
    last = float(faulty.sensed(0).sonar[9])
    for tick in range(8):
        right, wrong = sound.sense(tick, EAST), faulty.sense(tick, EAST)
        assert right.sonar_fresh == wrong.sonar_fresh
    others = [number for number in range(SONAR_COUNT) if number not in (0, 4, 9)]
    assert (wrong.sonar[others] == right.sonar[others]).all()
    assert wrong.sonar[[0, 4, 9]] == pytest.approx([math.inf, 0.8, last])
    for number in (0, 4, 9):
        faulty.mend_sonar(number)
    for tick in range(8, 12):
        right, wrong = sound.sense(tick, EAST), faulty.sense(tick, EAST)
    assert sensed_bytes(right) == sensed_bytes(wrong)


def test_a_knocked_striper_measures_too_far_and_looks_askew():
    senses = Senses(HARD, walls((2.0, -50, 2.0, 50)), 1)
    senses.knock_lasers(0.3, 0.2)
    log = [senses.sense(tick, EAST).striper for tick in range(200)]
    bearings = np.radians(np.arange(STRIPER_BEAMS) - 15) + 0.2
    assert np.median(log, axis=0) == pytest.approx(1.75 / np.cos(bearings) + 0.3, abs=0.02)


def test_sensor_faults_survive_a_snapshot():
    senses, again = Senses(HARD, CELL, 1), Senses(HARD, CELL, 1)
    senses.stick_sonar(3, math.inf)
    senses.stick_sonar(11, 0.5)
    senses.knock_lasers(-0.1, 0.05)
    again.restore(json.loads(json.dumps(senses.snapshot())))
    assert again.stuck_sonars == {3: math.inf, 11: 0.5}
    assert again.laser_offset == (-0.1, 0.05)


def test_what_a_robot_does_not_have_cannot_fail():
    with pytest.raises(NoSensorError, match="this robot has no sonar; 'xavier run --profile'"):
        Senses(MODERN, CELL, 1).stick_sonar(3)
    with pytest.raises(NoSensorError, match="this robot has no laser"):
        Senses(XAVIER.model_copy(update={"striper": None}), CELL, 1).knock_lasers(0.1, 0.0)


@pytest.mark.parametrize(
    ("kind", "fields", "says"),
    [
        (SonarFault, {"number": 24, "state": "dead"}, "number"),
        (
            SonarFault,
            {"number": 3, "state": "dead", "metres": 1.0},
            "expected no metres for a dead sonar",
        ),
        (SonarFault, {"number": 3, "state": "stuck", "metres": math.nan}, "metres"),
        (LaserOffset, {"metres": 2.0}, "metres"),
        (LaserOffset, {"turn": math.inf}, "turn"),
    ],
)
def test_a_fault_that_cannot_be_is_refused(kind, fields, says):
    with pytest.raises(ValidationError, match=says):
        kind(**fields)
