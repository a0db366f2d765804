from __future__ import annotations

import math

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from navigate.body import ROBOT_RADIUS, bump_direction, wrap
from navigate.driving import STOP, Surroundings, View, Wheels
from navigate.driving._arcs import FAR, blocked_curvatures, free_spans, shortest_arcs
from navigate.driving._cvm import (
    BRAKING,
    FREE_WEIGHT,
    HALT,
    HEADING_WEIGHT,
    HORIZON,
    LOOK_AHEAD,
    MARGIN,
    SPEED_WEIGHT,
    TOP_SPEED,
    Window,
    choose,
)
from navigate.driving._lanes import BERTH, free_ahead, pick_lane
from navigate.driving._safety import guard
from navigate.driving._surroundings import lean

coordinates = st.floats(-3.0, 3.0)
curvatures = st.just(0.0) | st.floats(1e-3, 3.0) | st.floats(-3.0, -1e-3)

FARTHEST = math.hypot(3.0, 3.0) + 0.8
"""Metres from the origin that no circle of these tests lies beyond."""


def arc(curvature, lengths):
    """Points on an arc from the origin, ahead along x: the definition, step by step."""
    if abs(curvature) < 1e-9:
        return np.column_stack([lengths, np.zeros_like(lengths)])
    turned = curvature * lengths
    return np.column_stack([np.sin(turned), 1.0 - np.cos(turned)]) / curvature


def samples(curvature):
    """Lengths along one turn of an arc, 2.7 mm apart or less, where it is near enough to meet.

    A point that lies s along the circle of curvature c is 2/c sin(cs/2) from the origin, so what
    is farther along than ``reach``, from either end, is farther away than any circle.
    """
    if curvature == 0.0:
        return np.linspace(0.0, FARTHEST, 3001)
    reach = 2.0 / abs(curvature) * math.asin(min(1.0, FARTHEST * abs(curvature) / 2.0))
    near = np.linspace(0.0, reach, 3001)
    return np.concatenate([near, 2.0 * math.pi / abs(curvature) - near[::-1]])


@settings(deadline=None, max_examples=120)
@given(coordinates, coordinates, st.floats(0.1, 0.8), curvatures)
def test_arcs_meet_circles_as_brute_force_says(x, y, radius, curvature):
    assume(math.hypot(x, y) > radius + 0.02)
    lengths = samples(curvature)
    away = np.hypot(*(arc(curvature, lengths) - [x, y]).T)
    assume(abs(away.min() - radius) > 0.01)
    low, high = blocked_curvatures(np.array([x]), np.array([y]), radius)
    meets = away.min() < radius
    if curvature != 0.0 or x > 0.0:
        assert bool(low[0] < curvature < high[0]) == meets
    if meets:
        entry = lengths[np.argmax(away < radius)]
        reach, turn = shortest_arcs(np.array([x]), np.array([y]), radius)
        assert reach[0] <= entry + 1e-6
        assert turn[0] <= abs(curvature) * entry + 1e-5


@settings(deadline=None, max_examples=60)
@given(coordinates, coordinates, st.floats(0.1, 0.8))
def test_no_arc_is_much_shorter_than_needed(x, y, radius):
    """Some arc to a circle ahead is as short as the bound, but for a radius and a half."""
    assume(math.hypot(x, y) > radius + 0.02 and x > 0.0)
    angles = np.linspace(-math.pi, math.pi, 721)
    rim_x, rim_y = x + radius * np.cos(angles), y + radius * np.sin(angles)
    aside = np.clip(np.abs(np.arctan2(rim_y, rim_x)), 1e-9, 3.14)
    shortest = (np.hypot(rim_x, rim_y) * aside / np.sin(aside)).min()
    bound = shortest_arcs(np.array([x]), np.array([y]), radius)[0][0]
    assert shortest - 1.5 * radius <= bound <= shortest + 1e-3


circles = st.lists(st.tuples(coordinates, coordinates), max_size=20)


@settings(deadline=None, max_examples=40)
@given(circles, st.floats(0.1, 0.6), curvatures)
def test_spans_promise_no_more_than_arcs_keep(spots, radius, curvature):
    hard = [spot for spot in spots if math.hypot(*spot) > radius + 0.02]
    x, y = np.array(hard).reshape(-1, 2).T
    spans = free_spans(x, y, radius)
    assert np.all(spans.low[1:] >= spans.high[:-1])
    low, high = blocked_curvatures(x, y, radius)
    assume(np.abs(np.concatenate([low, high, [1e9]]) - curvature).min() > 1e-3)
    met = (low < curvature) & (curvature < high)
    lengths = samples(curvature)
    path = arc(curvature, lengths)
    entries = [
        lengths[np.argmax(inside)]
        for spot in np.array(hard).reshape(-1, 2)[met]
        if (inside := np.hypot(*(path - spot).T) < radius).any()
    ]
    free = spans.at(curvature)
    assert free <= min(entries, default=FAR) + 1e-2
    assert free >= shortest_arcs(x, y, radius)[0][met].min(initial=FAR)


def test_what_is_behind_does_not_keep_a_robot_from_driving_on():
    behind = np.array([[-0.41, 0.2], [-0.12, -0.43]])
    choice = choose(behind, 0.0, Window.around(0.0, 0.0, 0.6))
    assert choice.wheels.speed > 0.1


def value(speed, turn, free, heading):
    """The objective of the method, as the paper writes it."""
    off = abs(heading - turn * LOOK_AHEAD) / math.pi
    return (
        SPEED_WEIGHT * speed / TOP_SPEED
        + FREE_WEIGHT * min(free, HORIZON) / HORIZON
        - HEADING_WEIGHT * off
    )


windows = st.builds(
    Window.around, st.floats(0.0, 0.6), st.floats(-0.9, 0.9), st.sampled_from([0.12, 0.35, 0.6])
)


@settings(deadline=None, max_examples=40)
@given(circles, st.floats(-0.8, 0.8), windows)
def test_the_choice_is_the_best_of_the_window(spots, heading, window):
    echoes = np.array(spots).reshape(-1, 2)
    choice = choose(echoes, heading, window)
    speed, turn, _ = choice.wheels
    spans = free_spans(*echoes.T, ROBOT_RADIUS + MARGIN, within=HORIZON)
    best = -math.inf
    for other in np.linspace(max(window.slowest, 0.01), window.fastest, 7):
        for bend in np.linspace(window.right, window.left, 13):
            free = spans.at(bend / other)
            if other**2 <= 2.0 * BRAKING * (free - HALT):
                best = max(best, value(other, bend, free, heading))
    if choice.wheels == STOP:
        assert best <= value(0.0, 0.0, FAR, heading)
    else:
        assert window.slowest - 1e-9 <= speed <= window.fastest + 1e-9
        assert window.right - 1e-9 <= turn <= window.left + 1e-9
        assert value(speed, turn, choice.free, heading) >= best - 1e-6


def test_the_window_is_what_the_base_can_reach_soon():
    at_rest = Window.around(0.0, 0.0, 0.6)
    assert at_rest.slowest == 0.0
    assert 0.05 < at_rest.fastest < 0.2
    assert at_rest.left == -at_rest.right < 0.9
    fast = Window.around(0.6, 0.9, 0.6)
    assert fast.slowest > 0.2
    assert fast.fastest == 0.6
    assert fast.left == 0.9
    assert Window.around(0.6, 0.0, 0.1).fastest == fast.slowest


def test_nothing_around_means_full_speed_towards_the_heading():
    ahead = choose(np.zeros((0, 2)), 0.0, Window.whole(0.6)).wheels
    assert ahead == Wheels(0.6, 0.0)
    assert choose(np.zeros((0, 2)), 0.5, Window.whole(0.6)).wheels.turn > 0.3


@settings(deadline=None, max_examples=60)
@given(circles, st.floats(-1.0, 1.0))
def test_a_choice_can_always_stop_before_what_it_sees(spots, heading):
    echoes = np.array(spots).reshape(-1, 2)
    choice = choose(echoes, heading, Window.whole(0.6))
    if choice.wheels.speed > 0.0:
        assert choice.wheels.speed**2 <= 2 * 0.5 * choice.free
        curvature = choice.wheels.turn / choice.wheels.speed
        path = arc(curvature, np.linspace(0.0, min(choice.free, 2.0) - 0.02, 50))
        hard = echoes[np.hypot(*echoes.T) > ROBOT_RADIUS + 0.1]
        for spot in hard:
            assert np.hypot(*(path - spot).T).min() > ROBOT_RADIUS


def test_no_way_on_means_stop():
    wall = np.column_stack([np.full(21, 0.42), np.linspace(-1, 1, 21)])
    assert choose(wall, 0.0, Window.whole(0.6)).wheels == STOP


@given(st.lists(st.tuples(st.floats(0.2, 3.0), coordinates), max_size=15))
def test_lanes_are_free_up_to_the_first_echo_in_them(spots):
    echoes = np.array(spots).reshape(-1, 2)
    offsets = np.array([-0.5, 0.0, 0.5])
    for offset, free in zip(offsets, free_ahead(echoes, offsets), strict=True):
        inside = [x for x, y in spots if abs(y - offset) < BERTH]
        assert free == (min(inside) - ROBOT_RADIUS if inside else math.inf)


def test_the_lane_beside_an_obstacle_is_taken_where_the_floor_is_wide_enough():
    box = np.array([[1.0, -0.1], [1.0, 0.0], [1.0, 0.1]])
    assert abs(pick_lane(box, 0.0, -0.8, 0.8).offset) > 0.4
    assert pick_lane(box, 0.0, -0.2, 0.2).free < 1.0
    assert pick_lane(box, 0.0, 0.0, 0.8).offset > 0.4
    assert pick_lane(np.zeros((0, 2)), 0.3, -0.8, 0.8).offset == 0.0


def test_a_lane_that_was_chosen_is_kept_while_something_is_ahead():
    box = np.array([[1.5, -0.1], [1.5, 0.0], [1.5, 0.1]])
    for chosen in (-0.6, 0.6):
        assert pick_lane(box, 0.0, -0.8, 0.8, chosen).offset * chosen > 0.0
    assert pick_lane(np.zeros((0, 2)), 0.6, -0.8, 0.8, 0.6).offset == 0.0


def test_what_two_neighbours_hear_is_between_them():
    ranges = np.full(24, np.inf)
    ranges[[0, 1, 2]] = 1.0, 1.1, 1.1
    leans = [lean(ranges.tolist(), sonar) for sonar in range(24)]
    assert leans[0] == -leans[2] > 0.1
    assert leans[1] == 0.0
    assert not any(leans[3:])


def test_a_kept_echo_goes_when_sonars_hear_what_is_behind_it():
    ranges = np.full(24, np.inf)
    ranges[0] = 0.5
    heard = Surroundings()
    heard.hear((0.0, 0.0, 0.0), ranges, 1, 0.0)
    ranges[0] = 2.0
    for time in (0.4, 0.8):
        heard.hear((0.0, 0.0, 0.0), ranges, 1, time)
    around = heard.picture((0.0, 0.0, 0.0), within=3.0).spots
    np.testing.assert_allclose(around, [[2.25, 0.0]])


def view(*, ranges=None, echoes=(), bump=0):
    return View(
        time=0.0,
        pose=(0.0, 0.0, 0.0),
        odom=(0.0, 0.0, 0.0),
        ranges=np.full(24, np.inf) if ranges is None else ranges,
        fresh=0,
        bump=bump,
        echoes=np.array(echoes, dtype=float).reshape(-1, 2),
    )


def test_a_sudden_obstacle_stops_the_wheels_but_not_the_turn():
    fast = Wheels(0.6, 0.3)
    assert guard(fast, view(echoes=[(2.0, 0.0)])) == fast
    assert guard(fast, view(echoes=[(0.45, 0.1)])) == Wheels(0.0, 0.3)
    assert guard(fast, view(echoes=[(0.45, 0.6)])) == fast


def test_what_is_behind_stops_a_robot_that_backs():
    back = Wheels(-0.15, 0.1)
    assert guard(back, view(echoes=[(-2.0, 0.0), (0.4, 0.0)])) == back
    assert guard(back, view(echoes=[(-0.36, 0.1)])) == Wheels(0.0, 0.1)
    rear = np.full(24, np.inf)
    rear[12] = 0.2
    assert guard(back._replace(narrow=True), view(ranges=rear)).speed == 0.0


def test_with_somebody_right_beside_it_the_robot_only_creeps():
    beside = np.full(24, np.inf)
    beside[21] = 0.2
    assert guard(Wheels(0.4, 0.0), view(ranges=beside)) == Wheels(0.1, 0.0)
    assert guard(Wheels(-0.15, 0.0), view(ranges=beside)) == Wheels(-0.15, 0.0)
    assert guard(Wheels(0.2, 0.0, narrow=True), view(ranges=beside)).speed == 0.2


def test_in_a_door_only_what_is_straight_ahead_counts():
    slow = Wheels(0.2, 0.0, narrow=True)
    jambs = np.full(24, 0.25)
    jambs[0] = 2.0
    assert guard(slow, view(ranges=jambs, echoes=[(0.35, 0.28)])) == slow
    jambs[0] = 0.2
    assert guard(slow, view(ranges=jambs)).speed == 0.0


def test_a_contact_stops_what_pushes_against_it():
    assert guard(Wheels(0.3, 0.1), view(bump=0b1)) == STOP
    assert guard(Wheels(-0.1, 0.0), view(bump=0b1)) == Wheels(-0.1, 0.0)
    assert guard(Wheels(-0.1, 0.0), view(bump=0b10000)) == STOP


@given(st.integers(0, 255))
def test_the_direction_of_a_bump_is_that_of_its_panels(panels):
    direction = bump_direction(panels)
    if panels == 0:
        assert direction is None
    elif panels.bit_count() == 1:
        number = panels.bit_length() - 1
        assert abs(wrap(direction - number * math.pi / 4)) < 1e-9


def test_echoes_stay_where_they_were_heard_while_the_robot_moves():
    ranges = np.full(24, np.inf)
    ranges[0] = 0.75
    heard = Surroundings()
    heard.hear((0.0, 0.0, 0.0), ranges, 1, 0.0)
    np.testing.assert_allclose(heard.picture((0.5, 0.0, 0.0), within=3.0).spots[0], [0.5, 0.0])
    turned = heard.picture((1.0, -0.5, math.pi / 2), within=3.0).spots[0]
    np.testing.assert_allclose(turned, [0.5, 0.0], atol=1e-12)


def test_an_echo_goes_when_its_sonar_hears_nothing_more():
    ranges = np.full(24, np.inf)
    ranges[3] = 2.0
    heard = Surroundings()
    heard.hear((0.0, 0.0, 0.0), ranges, 0xFFFFFF, 0.0)
    assert len(heard.picture((0.0, 0.0, 0.0), within=3.0).spots) == 1
    heard.hear((0.0, 0.0, 0.0), np.full(24, np.inf), 0xFFFFFF, 0.4)
    assert len(heard.picture((0.0, 0.0, 0.0), within=3.0).spots) == 0


def test_near_echoes_are_kept_for_a_few_seconds_and_bounded():
    heard = Surroundings()
    for tick in range(300):
        heard.hear((0.0, 0.0, 0.0), np.full(24, 0.5), 0xFFFFFF, tick * 0.1)
    assert len(heard.picture((0.0, 0.0, 0.0), within=3.0).spots) <= 2 * 24
    heard.hear((0.0, 0.0, 0.0), np.full(24, np.inf), 0xFFFFFF, 60.0)
    assert len(heard.picture((0.0, 0.0, 0.0), within=3.0).spots) == 0
