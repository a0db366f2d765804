"""Directives on a belief, on maps small enough to reckon by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from navigate_rings import TRUE

from navigate.freezing import freeze, thaw
from navigate.position._markov import MarkovModel
from navigate.position._policy import FORWARD_SECONDS, TURN_SECONDS, Directive, Policy
from navigate.position._topology import Kind, Place, Topology, build_topology

EAST, NORTH, WEST, SOUTH = range(4)


def cross():
    """Places 0 to 4 in a row to the east, and place 5 north of place 2."""
    topology = Topology()
    for x in range(5):
        topology.add(Place(Kind.CORRIDOR, "corridor", (float(x), 0.0)))
    topology.add(Place(Kind.CORRIDOR, "corridor", (2.0, 1.0)))
    for one, other in ((0, 1), (1, 2), (2, 3), (3, 4), (2, 5)):
        topology.join(one, other, bounds=(1, 1))
    return MarkovModel(topology)


def settled(model, goal):
    """The policy for a goal, worked out to the end."""
    policy = Policy(model)
    policy.aim(goal)
    while not policy.work():
        pass
    return policy


MODEL = cross()
POLICY = settled(MODEL, (2.0, 1.0))


def test_it_is_worked_out_a_little_at_a_time_and_can_be_kept_meanwhile():
    one, other = Policy(MODEL), Policy(MODEL)
    one.aim((2.0, 1.0))
    assert not one.work(sweeps=2)
    thaw(other, json.loads(json.dumps(freeze(one))))
    while not other.work(sweeps=1):
        pass
    assert other.goal == (2.0, 1.0)
    assert (other.costs == POLICY.costs).all()
    assert (other.best == POLICY.best).all()


def belief(*states):
    chances = np.zeros((4, len(MODEL.locations)))
    for location, heading, chance in states:
        chances[heading, location] = chance
    return chances.ravel()


def test_costs_are_those_of_the_shortest_way():
    costs = POLICY.costs.reshape(4, -1)
    assert costs[NORTH, 5] == 0.0
    assert costs[NORTH, 2] == FORWARD_SECONDS
    assert costs[EAST, 0] == pytest.approx(3 * FORWARD_SECONDS + TURN_SECONDS)
    assert costs[WEST, 0] == pytest.approx(3 * FORWARD_SECONDS + 3 * TURN_SECONDS)


def test_each_state_has_the_directive_of_the_shortest_way():
    best = POLICY.best.reshape(4, -1)
    assert best[EAST, 0] == Directive.FORWARD
    assert best[EAST, 2] == Directive.LEFT
    assert best[WEST, 2] == Directive.RIGHT
    assert best[NORTH, 2] == Directive.FORWARD
    assert best[NORTH, 5] == Directive.STOP


def test_by_vote_many_states_of_little_mass_outweigh_one_of_more():
    chances = belief((2, EAST, 0.4), (0, EAST, 0.3), (1, EAST, 0.3))
    choice = POLICY.choose(chances)
    assert choice.directive == Directive.FORWARD
    assert choice.share == pytest.approx(0.6)
    assert POLICY.choose(chances, picking="mls").directive == Directive.LEFT


def test_qmdp_weighs_what_a_wrong_directive_costs():
    chances = belief((5, NORTH, 0.6), (2, NORTH, 0.4))
    assert POLICY.choose(chances).directive == Directive.STOP
    assert POLICY.choose(chances, picking="mls").directive == Directive.STOP
    assert POLICY.choose(chances, picking="qmdp").directive != Directive.STOP


@pytest.mark.parametrize("picking", ["voting", "mls", "qmdp"])
def test_on_the_whole_floor_directives_lead_from_the_foyer_into_a_room(picking):
    model = MarkovModel(build_topology(TRUE))
    place = TRUE.place("r-5305")
    policy = settled(model, place)
    at, heading = _nearest(model, (TRUE.plan.start.x, TRUE.plan.start.y)), EAST
    for _ in range(80):
        chances = np.zeros(model.size)
        chances[heading * len(model.locations) + at] = 1.0
        directive = policy.choose(chances, picking=picking).directive
        if directive == Directive.STOP:
            break
        if directive == Directive.FORWARD:
            hops = model.hops[heading][at]
            at = max(hops, key=lambda to: hops[to])
        else:
            heading = (heading + (1 if directive == Directive.LEFT else -1)) % 4
    assert directive == Directive.STOP
    assert math.dist(model.locations.at[at], place) < 1.0


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_the_vote_is_that_of_the_mass(seed):
    chances = np.random.default_rng(seed).dirichlet(np.full(MODEL.size, 0.2))
    choice = POLICY.choose(chances)
    assert choice.share == pytest.approx(chances[POLICY.best == choice.directive].sum())
    assert choice.share >= 0.25 - 1e-9


def _nearest(model, spot):
    return int(np.hypot(*(model.locations.at - spot).T).argmin())
