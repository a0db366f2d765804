"""Which senses the navigator believes: sonars that die or stick, and a laser that was knocked."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navigate.body import STRIPER, Perception
from xavier_sim.messages import LIDAR_BEAMS, STRIPER_BEAMS, Sensors

ALL = (1 << 24) - 1
PHASES = 4

Pose = tuple[float, float, float]


class Walk:
    """A robot that walks about in a round hall, whose sonars hear the wall, more or less."""

    def __init__(self, *, noise: float = 0.02, striper: bool = False, knocked: float = 0.0) -> None:
        self.perception = Perception()
        self._random = np.random.default_rng(7)
        self._noise, self._striper, self._knocked = noise, striper, knocked
        self._ring = np.full(24, np.inf)
        self.tick = 0
        self.odom: Pose = (0.0, 0.0, 0.0)

    def go(self, ticks: int, broken: dict[int, float] | None = None, *, still: bool = False):
        """Walk for some ticks, with sonars that read the same whatever is there."""
        percept = None
        for _ in range(ticks):
            self.tick += 1
            if not still:
                x, y, theta = self.odom
                self.odom = (x + 0.03 * math.cos(theta), y + 0.03 * math.sin(theta), theta + 0.02)
            part = np.arange(self.tick % PHASES, 24, PHASES)
            true = 1.2 + 0.2 * math.sin(0.1 * self.tick)
            self._ring[part] = true + self._noise * self._random.standard_normal(len(part))
            for sonar, reading in (broken or {}).items():
                self._ring[sonar] = reading
            fresh = sum(1 << int(sonar) for sonar in part)
            percept = self.perception.take_in(self._sensors(fresh, true), self.odom)
        assert percept is not None
        return percept

    def _sensors(self, fresh: int, true: float) -> Sensors:
        beams = np.full(STRIPER_BEAMS, true + self._knocked) if self._striper else np.empty(0)
        return Sensors(
            tick=self.tick,
            time=0.1 * self.tick,
            period=0.1,
            lockstep=True,
            sonar=self._ring.astype(np.float32),
            sonar_fresh=fresh,
            odom=np.array(self.odom, dtype=np.float32),
            speed=0.3,
            turn_rate=0.2,
            bump=0,
            striper=beams.astype(np.float32),
        )


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_sound_sonars_are_all_believed(noise):
    walk = Walk(noise=noise, striper=True)
    percept = walk.go(1000)
    assert walk.perception.faults == {}
    np.testing.assert_array_equal(percept.ring, percept.own)
    assert np.isfinite(percept.own).all()


def test_a_sonar_that_hears_nothing_where_its_neighbours_do_is_dead():
    walk = Walk()
    percept = walk.go(200, {3: np.inf})
    assert walk.perception.faults == {"sonar 3": "dead"}
    assert np.isinf(percept.own[3])
    assert abs(percept.ring[3] - percept.own[[2, 4]].max()) < 1e-9


def test_one_that_is_silent_where_it_stands_may_glance_off_for_ever():
    walk = Walk()
    walk.go(20)
    walk.go(500, {3: np.inf}, still=True)
    assert walk.perception.faults == {}


def test_one_that_never_wavers_is_stuck_also_while_the_robot_stands():
    walk = Walk()
    walk.go(40)
    percept = walk.go(100, {5: 0.5}, still=True)
    assert walk.perception.faults == {"sonar 5": "stuck"}
    assert percept.ring[5] > 0.9


def test_without_noise_one_is_stuck_that_stays_the_same_through_a_turn():
    walk = Walk(noise=0.0)
    walk.go(20, {5: 0.5})
    assert walk.perception.faults == {}
    walk.go(120, {5: 0.5})
    assert walk.perception.faults == {"sonar 5": "stuck"}


@pytest.mark.parametrize("reading", [np.inf, 0.5])
def test_what_behaves_again_is_believed_again(reading):
    walk = Walk()
    walk.go(300, {7: reading})
    assert list(walk.perception.faults) == ["sonar 7"]
    percept = walk.go(40)
    assert walk.perception.faults == {}
    assert np.isfinite(percept.own[7])


def test_a_sonar_that_stands_in_is_new_when_it_is_heard():
    walk = Walk()
    walk.go(200, {0: np.inf})
    for _ in range(8):
        percept = walk.go(1, {0: np.inf})
        assert not percept.fresh & 1
        assert bool(percept.renewed & 1) == bool(percept.fresh & (1 << 1 | 1 << 23))


def test_where_the_neighbours_disagree_the_farther_stands_in_unless_it_is_near():
    walk = Walk()
    walk.go(200, {0: np.inf})
    assert walk.go(1, {0: np.inf, 1: 2.0, 23: 1.0}).ring[0] == pytest.approx(2.0)
    assert walk.go(1, {0: np.inf, 1: 2.0, 23: 0.3}).ring[0] == pytest.approx(0.3)


def test_light_stands_in_for_the_sonar_that_looks_where_it_does():
    walk = Walk(striper=True)
    percept = walk.go(200, {0: np.inf})
    assert walk.perception.faults == {"sonar 0": "dead"}
    assert percept.ring[0] == pytest.approx(percept.lit[0])
    assert percept.renewed & 1


def test_a_knocked_striper_is_off_and_left_out_until_it_is_right():
    walk = Walk(striper=True, knocked=0.12)
    percept = walk.go(600)
    assert walk.perception.faults == {"striper": "off"}
    assert percept.sights == ()
    assert len(percept.striper) == 0
    walk._knocked = 0.0
    percept = walk.go(600)
    assert walk.perception.faults == {}
    assert len(percept.striper) == STRIPER_BEAMS


def test_a_laser_tells_points_and_what_sonars_would_read():
    sight = STRIPER.look(np.full(STRIPER_BEAMS, 1.0, dtype=np.float32))
    assert sight is not None
    np.testing.assert_allclose(sight.spots[15], [1.25, 0.0], atol=1e-9)
    assert sight.ring[0] == pytest.approx(1.0)
    assert np.isfinite(sight.ring).sum() == 3
    assert STRIPER.look(np.full(LIDAR_BEAMS, 1.0, dtype=np.float32)) is None


def test_what_no_laser_can_see_is_nothing():
    beams = np.full(STRIPER_BEAMS, np.nan, dtype=np.float32)
    beams[:3] = 0.0, 0.1, 9.0
    sight = STRIPER.look(beams)
    assert sight is not None
    assert np.isinf(sight.ranges).all()
    assert np.isinf(sight.ring).all()
