"""The Markov model and its belief, on maps small enough to reckon by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from navigate_rings import TRUE

from navigate.body import Front, Moved, Side, Turned
from navigate.maps import Floor
from navigate.position._features import Features
from navigate.position._markov import BLOCKED, MarkovModel
from navigate.position._markov_belief import ANYWHERE, MarkovBelief
from navigate.position._topology import Kind, Place, Topology, build_topology, lengths
from xavier_sim.messages import Corner, Door, FloorPlan, Space, SpaceKind

EAST, NORTH, WEST = 0, 1, 2


def line(*bounds):
    """Places in a row to the east, joined by edges of so many to so many cells."""
    topology = Topology()
    at = 0.0
    topology.add(Place(Kind.CORRIDOR, "corridor", (at, 0.0)))
    for index, (least, most) in enumerate(bounds):
        at += (least + most) / 2
        topology.add(Place(Kind.CORRIDOR, "corridor", (at, 0.0)))
        topology.join(index, index + 1, bounds=(least, most))
    return MarkovModel(topology)


def surely(model, location, heading):
    belief = np.zeros((4, len(model.locations)))
    belief[heading, location] = 1.0
    return belief.ravel()


def by_location(model, belief, heading):
    return belief.reshape(4, -1)[heading]


def plan():
    """A corridor of 12 m to the east, with a room at either end of its north side."""
    rooms = [
        Space(
            name=f"r-{i}",
            kind=SpaceKind.ROOM,
            low=Corner(x=x, y=2.4),
            high=Corner(x=x + 4.0, y=6.4),
        )
        for i, x in ((1, 0.0), (2, 8.0))
    ]
    corridor = Space(
        name="c", kind=SpaceKind.CORRIDOR, low=Corner(x=0, y=0), high=Corner(x=12, y=2.4)
    )
    doors = tuple(
        Door(name=f"d-{i}", between=("c", f"r-{i}"), at=Corner(x=x, y=2.4))
        for i, x in ((1, 2.0), (2, 10.0))
    )
    places = {"r-1": Corner(x=2.0, y=3.1), "r-2": Corner(x=10.0, y=3.1)}
    return FloorPlan(
        name="tiny",
        spaces=(corridor, *rooms),
        doors=doors,
        places=places,
        start=Corner(x=6.0, y=1.2),
    )


TINY = Floor(plan())
MODEL = MarkovModel(build_topology(TINY))
FEATURES = Features(TINY, MODEL.locations.at)


def test_a_metre_forward_is_none_one_or_two_cells():
    model = line((1, 1), (1, 1), (1, 1))
    after = by_location(model, model.moved(surely(model, 0, EAST), relative=0), EAST)
    assert after == pytest.approx([0.1, 0.8, 0.1, 0.0])


def test_a_metre_backward_leads_the_other_way():
    model = line((1, 1), (1, 1))
    after = by_location(model, model.moved(surely(model, 2, EAST), relative=2), EAST)
    assert after == pytest.approx([0.1, 0.8, 0.1])


def test_an_edge_of_two_or_three_metres_ends_after_either():
    model = line((2, 3))
    start, end, first, second = 0, 1, 2, 3
    once = by_location(model, model.moved(surely(model, start, EAST), relative=0), EAST)
    assert once[[start, first]] == pytest.approx([0.1, 0.8])
    assert once[[second, end]] == pytest.approx([0.1 * 0.5, 0.1 * 0.5])
    from_first = by_location(model, model.moved(surely(model, first, EAST), relative=0), EAST)
    assert from_first[second] == pytest.approx(0.8 * 0.5)
    assert from_first[end] == pytest.approx(0.8 * 0.5 + 0.1 * 0.5 + 0.1 * 0.5 * BLOCKED)


def test_a_chain_that_is_turned_round_in_leads_back_by_as_many_metres():
    model = line((3, 4))
    back = by_location(model, model.moved(surely(model, 3, WEST), relative=0), WEST)
    assert back[[3, 2, 0]] == pytest.approx([0.1, 0.8, 0.1])


def test_the_two_ends_of_a_chain_are_told_apart():
    model = line((2, 2))
    assert len(model.locations) == 2 + 2
    from_east = by_location(model, model.moved(surely(model, 1, WEST), relative=0), WEST)
    assert from_east[3] == pytest.approx(0.8)
    assert from_east[2] == 0.0


def test_a_metre_into_a_wall_is_improbable():
    model = line((1, 1))
    after = model.moved(surely(model, 0, NORTH), relative=0)
    assert after.sum() == pytest.approx(0.1 + 0.8 * BLOCKED + 0.1 * BLOCKED**2)


def test_a_turn_may_fall_short_or_go_too_far():
    model = line((1, 1))
    after = model.turned(surely(model, 1, EAST), quarters=1).reshape(4, -1)[:, 1]
    assert after == pytest.approx([0.05, 0.9, 0.05, 0.0])


def test_a_report_weighs_states_by_how_probable_it_is_there():
    class Fixed:
        def likelihood(self, front, left, right):
            assert (front, left, right) == (Front.WALL, None, Side.SMALL)
            return np.array([0.9] + [0.1] * 7)

    model = line((1, 1))
    belief = MarkovBelief(model, Fixed())
    belief.see(Front.WALL, None, Side.SMALL)
    seen = 0.9 / 1.6
    assert belief.chances[0] == pytest.approx((1 - ANYWHERE) * seen + ANYWHERE / 8)
    assert belief.chances.sum() == pytest.approx(1.0)


def test_a_belief_that_knows_nothing_has_the_entropy_of_all_states():
    belief = MarkovBelief(MODEL, FEATURES)
    assert belief.entropy == pytest.approx(math.log2(MODEL.size))
    belief.chances = surely(MODEL, 0, EAST)
    assert belief.entropy == 0.0


def test_a_length_that_is_known_within_bounds_is_one_of_some_cells():
    assert lengths(1.0) == {1: 1.0}
    assert set(lengths(3.6)) == {3, 4}
    assert sum(lengths(12.0).values()) == pytest.approx(1.0)
    assert min(lengths(12.0)) < 12 < max(lengths(12.0))


def test_each_room_is_entered_through_its_door():
    topology = MODEL.topology
    for door, room in (("d-1", "r-1"), ("d-2", "r-2")):
        index = next(i for i, place in enumerate(topology.places) if place.space == door)
        ends = [edge.one for edge in topology.edges if edge.other == index]
        assert {topology.places[end].space for end in ends} == {"c", room}
        assert topology.places[index].kind is Kind.DOOR


def test_features_tell_a_door_from_a_wall_and_an_end_from_a_corridor():
    at = MODEL.locations.at
    by_door, between = (int(np.hypot(*(at - spot).T).argmin()) for spot in ((2.4, 1.2), (6, 1.2)))
    assert FEATURES.left[EAST, by_door, Side.SMALL] > FEATURES.left[EAST, between, Side.SMALL]
    assert FEATURES.right[EAST, by_door].argmax() == Side.WALL
    end = int(np.hypot(*(at - (11.4, 1.2)).T).argmin())
    assert FEATURES.front[EAST, end].argmax() == Front.WALL
    assert FEATURES.front[WEST, end].argmax() == Front.CLEAR


def test_who_drives_past_one_door_and_into_the_next_is_in_the_second_room():
    belief = MarkovBelief(MODEL, FEATURES)
    for side in (Side.SMALL, *[Side.WALL] * 6):
        belief.see(Front.CLEAR, side, Side.WALL)
        belief.report(Moved(0))
    belief.see(Front.WALL, Side.SMALL, Side.WALL)
    belief.report(Turned(1))
    for _ in range(2):
        belief.report(Moved(0))
    assert belief.near((10.0, 3.1), within=1.5) > 0.5
    x, y, theta = belief.likely()
    assert math.dist((x, y), (10.0, 3.1)) < 1.5
    assert theta == pytest.approx(math.pi / 2)


def test_what_it_is_told_is_what_it_believes():
    belief = MarkovBelief(MODEL, FEATURES)
    belief.know((10.0, 3.1, 1.5))
    assert belief.near((10.0, 3.1), within=1.5) > 0.8
    told = belief.tell()
    assert told.shares.sum() == pytest.approx(1.0)
    assert told.poses[0][2] == pytest.approx(math.pi / 2)


SEEN = [
    (front, left, right)
    for front in (None, *Front)
    for left in (None, *Side)
    for right in (None, *Side)
]
REPORTS = [*map(Moved, range(4)), Turned(-1), Turned(1), *SEEN]


@settings(max_examples=30, deadline=None)
@given(st.lists(st.sampled_from(REPORTS), max_size=20))
def test_a_belief_stays_a_distribution_whatever_is_reported(history):
    belief = MarkovBelief(MODEL, FEATURES)
    for report in history:
        if isinstance(report, tuple):
            belief.see(*report)
        else:
            belief.report(report)
        assert belief.chances.sum() == pytest.approx(1.0)
        assert (belief.chances >= 0.0).all()
        assert 0.0 <= belief.entropy <= math.log2(MODEL.size) + 1e-9


def test_no_row_of_the_whole_floor_s_model_gains_mass():
    model = MarkovModel(build_topology(TRUE))
    even = np.full(model.size, 1.0 / model.size)
    for relative in range(4):
        assert 0.2 < model.moved(even, relative=relative).sum() <= 1.0 + 1e-9
    assert model.turned(even, quarters=-1).sum() == pytest.approx(1.0)
