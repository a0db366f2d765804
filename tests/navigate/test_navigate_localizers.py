"""What every localizer promises the navigator."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from navigate_loop import true_plan

from navigate.body import Motion, wrap
from navigate.maps import Floor
from navigate.messages import LocalizerName
from navigate.navigator import Navigator
from navigate.position import DeadReckoning, make_localizer
from navigate.position._localizer import in_cells
from tca_bus import ConfigError

FLOOR = Floor(true_plan())
START = (FLOOR.plan.start.x, FLOOR.plan.start.y, FLOOR.plan.start_heading)
NAMES = get_args(LocalizerName)
shares = st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=30)


@pytest.fixture(params=NAMES)
def localizer(request):
    return make_localizer(request.param, FLOOR, seed=1)


def test_it_starts_where_the_map_says(localizer):
    assert math.dist(localizer.estimate.pose[:2], START[:2]) < 0.1
    assert localizer.mass_near(*START[:2], within=1.0) > 0.9
    assert not localizer.lost


def test_only_the_pomdp_starts_anywhere():
    assert make_localizer("pomdp", FLOOR, start="anywhere").lost
    for name in sorted({*NAMES} - {"pomdp"}):
        with pytest.raises(ConfigError, match=f"--localizer pomdp: {name} finds no robot"):
            make_localizer(name, FLOOR, start="anywhere")


def test_its_belief_is_a_distribution(localizer):
    localizer.move(Motion(0.5, 0.0, 0.2))
    belief = localizer.belief()
    assert belief.shares.sum() == pytest.approx(1.0)
    assert (np.diff(belief.shares) <= 0.0).all()
    assert np.isfinite(belief.poses).all()
    assert belief.entropy >= 0.0


def test_it_believes_what_it_is_told(localizer):
    x, y = FLOOR.place("r-5303")
    localizer.place((x, y, math.pi), spread=0.1, turn_spread=0.1)
    here = localizer.estimate
    assert math.dist((here.x, here.y), (x, y)) < 0.2
    assert abs(abs(here.theta) - math.pi) < 0.2
    assert localizer.mass_near(x, y, within=0.6) > 0.9


def test_what_nobody_saw_makes_it_less_sure(localizer):
    before = localizer.estimate
    localizer.widen(spread=0.5, turn_spread=0.3)
    assert localizer.estimate.deviation > before.deviation + 0.2
    assert localizer.estimate.heading_deviation > before.heading_deviation + 0.1


@pytest.mark.parametrize("theta", [math.pi - 0.02, -math.pi + 0.02, 0.4])
def test_it_takes_in_which_way_the_robot_looks(localizer, theta):
    x, y = FLOOR.place("r-5303")
    localizer.place((x, y, theta + 0.15), spread=0.1, turn_spread=0.1)
    before = localizer.estimate
    localizer.orient(theta, spread=0.03)
    here = localizer.estimate
    if isinstance(localizer, DeadReckoning):
        assert here == before
        return
    assert abs(wrap(here.theta - theta)) < 0.05
    assert here.heading_deviation < before.heading_deviation - 0.02
    assert math.dist(here.pose[:2], before.pose[:2]) < 0.1


def test_a_look_that_nothing_speaks_for_changes_little(localizer):
    before = localizer.estimate
    localizer.orient(wrap(before.theta + 1.2), spread=0.03)
    here = localizer.estimate
    assert abs(wrap(here.theta - before.theta)) < 0.01
    assert math.dist(here.pose[:2], before.pose[:2]) < 0.01
    assert not localizer.lost


def test_a_navigator_goes_by_the_localizer_it_is_given():
    reckoning = DeadReckoning(FLOOR)
    navigator = Navigator(FLOOR, localizer=reckoning)
    reckoning.place((7.5, 20.0, 0.5))
    assert (navigator.position().x, navigator.position().y) == (7.5, 20.0)


def test_dead_reckoning_adds_up_what_the_wheels_say():
    reckoning = DeadReckoning(FLOOR)
    reckoning.place((1.0, 2.0, 0.0))
    for _ in range(10):
        reckoning.move(Motion(0.1, 0.0, 0.0))
    reckoning.move(Motion(0.0, 0.0, math.pi / 2))
    reckoning.move(Motion(2.0, 0.0, 0.0))
    assert reckoning.estimate.pose == pytest.approx((2.0, 4.0, math.pi / 2))
    assert reckoning.estimate.deviation == pytest.approx(0.05 + 3 * 0.03)


def test_a_belief_in_two_cells_has_an_entropy_of_one_bit():
    x, y, theta = np.array([0.2, 0.8, 5.5]), np.array([0.5, 0.5, 0.5]), np.array([0.1, -0.1, 3.1])
    belief = in_cells(x, y, theta, np.array([1.0, 1.0, 2.0]))
    assert belief.entropy == pytest.approx(1.0)
    near = belief.poses[np.argsort(belief.poses[:, 0])]
    assert near == pytest.approx(np.array([[0.5, 0.5, 0.0], [5.5, 0.5, 3.1]]))


@given(shares, st.integers(0, 1000))
def test_the_entropy_lies_between_none_and_that_of_an_even_belief(shares, seed):
    random = np.random.default_rng(seed)
    x, y, theta = random.uniform(-9, 9, (3, len(shares)))
    belief = in_cells(x, y, theta, np.array(shares))
    assert belief.shares.sum() == pytest.approx(1.0)
    assert 0.0 <= belief.entropy <= math.log2(len(belief.shares)) + 1e-9
