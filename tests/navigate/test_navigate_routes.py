from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navigate.maps import Floor, load_plan
from navigate.routes import (
    CERTAIN,
    REMEMBER,
    Distances,
    Hindrances,
    Memory,
    NoRouteError,
    Planner,
    as_table,
    describe,
)
from navigate.routes._graph import MISS_SECONDS, Node, missing, straight
from xavier_sim.messages import SpaceKind

FLOOR = Floor(load_plan())
PLANNER = Planner(FLOOR)
ROOMS = sorted(FLOOR.places)
DOORS = sorted(FLOOR.doors)
rooms = st.sampled_from(ROOMS)


def brute_force(start, goal, shut):
    """Seconds of the best way, by relaxing all links until nothing changes (Bellman-Ford)."""
    nodes = PLANNER.graph.nodes
    here, there = (FLOOR.space_at(*point).name for point in (start, goal))
    if here == there:
        return straight(math.dist(start, goal))
    best = [
        straight(math.dist(start, node.at)) + missing(start, node)
        if node.space == here
        else math.inf
        for node in nodes
    ]
    changed = True
    while changed:
        changed = False
        for link in PLANNER.graph.links:
            if link.door in shut:
                continue
            for one, other in ((link.one, link.other), (link.other, link.one)):
                cost = link.seconds_to(other)
                if best[one] + cost < best[other] - 1e-12:
                    best[other], changed = best[one] + cost, True
    return min(
        best[i] + straight(math.dist(node.at, goal))
        for i, node in enumerate(nodes)
        if node.space == there
    )


@settings(deadline=None, max_examples=40)
@given(rooms, rooms, st.sets(st.sampled_from(DOORS), max_size=30))
def test_a_star_finds_what_brute_force_finds(one, other, shut):
    start, goal = FLOOR.place(one), FLOOR.place(other)
    best = brute_force(start, goal, shut)
    try:
        steps = PLANNER.plan(start, goal, Hindrances(frozenset(shut)))
    except NoRouteError:
        assert math.isinf(best)
    else:
        assert math.isclose(sum(step.seconds for step in steps), best)
        assert not {step.door.name for step in steps if step.door} & shut
        assert steps[-1].to == goal


@settings(deadline=None, max_examples=40)
@given(rooms, rooms)
def test_routes_stay_on_the_floor_and_off_the_walls(one, other):
    at = FLOOR.place(one)
    for step in PLANNER.plan(at, FLOOR.place(other)):
        for part in range(11):
            x = at[0] + (step.to[0] - at[0]) * part / 10
            y = at[1] + (step.to[1] - at[1]) * part / 10
            assert step.door or FLOOR.free(x, y, clearance=0.3)
        at = step.to


def test_a_goal_in_a_wall_or_outside_has_no_route():
    start = FLOOR.place("r-5301")
    with pytest.raises(NoRouteError, match="no room for the robot"):
        PLANNER.plan(start, (6.37, 19.6 + 1.8))
    for goal in ((-20.0, 3.0), (1e9, 1e300)):
        with pytest.raises(NoRouteError, match=r"\(.{3,20}\): that lies in no space"):
            PLANNER.plan(start, goal)


def test_a_goal_in_the_open_is_reached_though_it_is_no_place():
    steps = PLANNER.plan(FLOOR.place("r-5301"), (20.0, 50.0))
    assert steps[-1].to == (20.0, 50.0)


def test_a_shut_door_leaves_no_route_and_the_error_names_it():
    with pytest.raises(NoRouteError, match="door d-5303"):
        PLANNER.plan(
            FLOOR.place("r-5301"), FLOOR.place("r-5303"), Hindrances(frozenset({"d-5303"}))
        )


def test_a_blocked_place_is_planned_around_and_may_be_left():
    start, goal = (7.54, 22.0), FLOOR.place("r-5313")
    near = PLANNER.plan(start, goal)
    far = PLANNER.plan(start, goal, Hindrances(points=((7.54, 23.0),)))
    assert sum(step.metres for step in far) > sum(step.metres for step in near) + 10
    assert any(step.space == "corridor-54" for step in far)


def test_from_between_two_spaces_the_way_leads_out_on_both_sides():
    goal = FLOOR.place("r-5313")
    start = (7.6, 17.95)
    blocked = Hindrances(points=((7.6, 18.7),))
    steps = PLANNER.plan(start, goal, blocked)
    assert steps[0].space == "crossing-south"
    assert any(step.space == "corridor-54" for step in steps)


def test_from_a_doorway_the_way_leads_straight_out_of_it():
    door = FLOOR.doors["d-5303"]
    steps = PLANNER.plan((door.centre[0] + 0.1, door.centre[1]), FLOOR.place("r-5313"))
    assert steps[0].door == door
    assert steps[0].space == "corridor-53"


def test_a_route_as_a_message_tells_points_doors_and_spaces():
    start = FLOOR.place("r-5301")
    route = describe(start, PLANNER.plan(start, FLOOR.place("r-5313")))
    assert route.via == ["r-5301", "d-5301", "corridor-53", "d-5313", "r-5313"]
    length = sum(math.dist(a, b) for a, b in zip(route.points, route.points[1:], strict=False))
    assert math.isclose(route.metres, length, abs_tol=0.05)


def test_standoffs_of_corridors_lie_on_their_centre_line():
    for node in PLANNER.graph.nodes:
        space = FLOOR.spaces[node.space]
        if space.kind is SpaceKind.CORRIDOR:
            assert FLOOR.free(*node.at, clearance=0.9)


def test_hindrances_are_remembered_for_a_while():
    memory = Memory()
    memory.shut("d-5303", 100.0)
    memory.blocked((1.0, 2.0), 150.0)
    assert memory.believed(150.0) == Hindrances(frozenset({"d-5303"}), ((1.0, 2.0),))
    assert memory.believed(150.0, age=CERTAIN).doors == frozenset()
    copy = Memory()
    copy.restore(memory.snapshot())
    assert copy.believed(151.0) == memory.believed(151.0)
    assert memory.believed(100.0 + REMEMBER).doors == frozenset()
    assert memory.outlook(110.0).doors == {"d-5303"}
    memory.forget_since(120.0)
    assert memory.believed(151.0).points == ()


def test_what_was_seen_long_ago_is_doubted_and_then_forgotten():
    memory = Memory()
    memory.shut("d-5303", 0.0)
    memory.blocked((1.0, 2.0), 0.0)
    costs = []
    for now in (30.0, 100.0, 400.0):
        outlook = memory.outlook(now)
        assert (outlook.doors, outlook.points) == (frozenset(), ())
        [(door, seconds)] = outlook.doubtful_doors
        [(point, more)] = outlook.doubtful_points
        assert (door, point) == ("d-5303", (1.0, 2.0))
        assert more > seconds > 0.0
        costs.append(seconds)
    assert costs == sorted(costs, reverse=True)
    assert memory.outlook(1000.0) == Hindrances()


def test_where_there_is_no_other_way_a_blocked_place_is_tried_again():
    memory = Memory()
    memory.blocked((1.0, 2.0), 0.0)
    assert memory.outlook(5.0).points == ((1.0, 2.0),)
    assert memory.outlook(5.0, way_is_free=True).points == ()
    assert memory.outlook(5.0, way_is_free=True).doubtful_points[0][1] > 100.0


def test_a_doubtful_place_is_avoided_where_that_costs_little():
    start, goal = (7.54, 22.0), FLOOR.place("r-5313")
    free = PLANNER.plan(start, goal)
    for seconds, far in ((1.0, False), (1e4, True)):
        doubt = Hindrances(doubtful_points=(((7.54, 26.0), seconds),))
        steps = PLANNER.plan(start, goal, doubt)
        assert (sum(step.metres for step in steps) > 10 + sum(s.metres for s in free)) == far
    doubt = Hindrances(doubtful_doors=(("d-5313", 30.0),))
    wary = PLANNER.plan(start, goal, doubt)
    assert sum(s.seconds for s in wary) == pytest.approx(30.0 + sum(s.seconds for s in free))


def test_a_turn_is_missed_more_easily_after_a_long_way():
    door = Node((10.0, 0.0), "corridor", "d", (0.0, 1.0))
    near, far = missing((8.0, 0.0), door), missing((0.0, 0.0), door)
    assert 0.0 < near < far < MISS_SECONDS
    assert missing((10.0, -5.0), door) == 0.0


def test_a_door_that_was_passed_is_not_shut():
    memory = Memory()
    memory.shut("d-5303", 100.0)
    memory.opened("d-5303")
    assert memory.believed(101.0) == Hindrances()


@settings(deadline=None, max_examples=20)
@given(st.lists(rooms, min_size=1, max_size=6), st.sets(st.sampled_from(DOORS), max_size=30))
def test_distances_between_many_are_those_of_the_routes_one_by_one(names, shut):
    places = [FLOOR.place(name) for name in names]
    blocked = Hindrances(doors=frozenset(shut))
    found = Distances(PLANNER).between(places, places, blocked)
    for start, row in zip(places, found, strict=True):
        for goal, reach in zip(places, row, strict=True):
            try:
                steps = PLANNER.plan(start, goal, blocked)
            except NoRouteError:
                assert reach is None
            else:
                assert reach.metres == pytest.approx(sum(step.metres for step in steps))
                assert reach.seconds == pytest.approx(sum(step.seconds for step in steps))


def test_distances_follow_what_is_in_the_way():
    distances = Distances(PLANNER)
    one, other = FLOOR.place("r-5303"), FLOOR.place("r-5313")
    doorway = (FLOOR.doors["d-5303"].centre[0], one[1])
    free, shut = Hindrances(), Hindrances(doors=frozenset({"d-5313"}))
    assert distances.between([one, doorway], [other], free)[0][0].metres == pytest.approx(
        18.0, abs=4.0
    )
    assert distances.between([one], [other], shut) == [[None]]
    assert distances.between([one], [(-9.0, 0.0)], free) == [[None]]
    table = as_table(["a"], [[None], distances.between([doorway], [other], free)[0]])
    assert table.metres == [[None]]
    assert 18.0 < table.from_here[0] < 22.0
