"""People who walk the corridors and carts that stand in them: seen, bumped into, counted."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_xavier_world import stroll

from xavier_sim.body import Disc, PeopleMet
from xavier_sim.crowd import Crowd, NoRoomError
from xavier_sim.crowd import _person as person_module
from xavier_sim.crowd._cart import APART, DOOR_CLEAR, CartSpots
from xavier_sim.crowd._cart import RADIUS as CART_RADIUS
from xavier_sim.crowd._person import RADIUS, Person
from xavier_sim.crowd._walkways import Walkways
from xavier_sim.floors import build_geometry, load_floor, segment_distances
from xavier_sim.messages import Corner, FloorPlan, Space, SpaceKind
from xavier_sim.profile import XAVIER
from xavier_sim.world import NotFreeError, World

PLAN = load_floor()
WALLS = build_geometry(PLAN).walls
MIDDLE, SOUTH = 7.57, 25.0
"""A point in the long corridor from which it runs to the north."""


def crowd_of(people, carts=0, seed=1, robots=()):
    return Crowd(PLAN, seed, people=people, carts=carts, robots=robots)


def walk(crowd, ticks, robots=(), bumped=()):
    for tick in range(ticks):
        crowd.step(tick, robots, bumped)


def stand(world, x, y, *, pause=1000.0):
    """Put the first person of a world somewhere, where they stay."""
    person = Person(x, y, speed=1.2, lane=0.5, pause=pause)
    world._crowd.people[0] = person
    world._crowd._list()
    return person


def facing(person_at, *, seed=1):
    """A robot in the corridor that looks north, and a person north of it."""
    world = World(PLAN, seed=seed, people=1)
    world.place_robot(MIDDLE, SOUTH, math.pi / 2)
    return world, stand(world, MIDDLE, SOUTH + person_at)


@settings(max_examples=4, deadline=None)
@given(st.integers(0, 100))
def test_people_walk_and_touch_neither_walls_nor_carts(seed):
    crowd = crowd_of(6, 3, seed)
    before = [(person.x, person.y) for person in crowd.people]
    for _ in range(100):
        walk(crowd, 5)
        for person in crowd.people:
            assert segment_distances(WALLS, person.x, person.y).min() > 0.1
            assert all(cart.disc().gap(person.x, person.y, RADIUS) > -0.05 for cart in crowd.carts)
    after = [(person.x, person.y) for person in crowd.people]
    assert sum(math.dist(a, b) > 2.0 for a, b in zip(before, after, strict=True)) >= 3


def rooms_of(crowd):
    """The rooms that somebody is in."""
    at = (crowd._walkways.room_at(person.x, person.y) for person in crowd.people)
    return [room for room in at if room is not None]


def until(crowd, come, ticks=4000):
    for tick in range(ticks):
        crowd.step(tick, (), ())
        if come():
            return
    pytest.fail("it did not come to that")


def test_some_people_go_into_rooms_one_to_each_and_come_out(monkeypatch):
    monkeypatch.setattr(person_module, "VISITS", 1.0)
    monkeypatch.setattr(person_module, "VISIT_SECONDS", (20.0, 30.0))
    crowd, seen, most = crowd_of(6, seed=3), set(), 0
    for tick in range(4000):
        crowd.step(tick, (), ())
        rooms = rooms_of(crowd)
        assert len(set(rooms)) == len(rooms)
        seen.update(rooms)
        most = max(most, len(rooms))
    assert most == 2
    assert len(seen) > 2


def test_a_shut_door_keeps_people_out_and_in(monkeypatch):
    monkeypatch.setattr(person_module, "VISITS", 1.0)
    monkeypatch.setattr(person_module, "VISIT_SECONDS", (1.0, 2.0))
    crowd = crowd_of(3, seed=2)
    until(crowd, lambda: rooms_of(crowd))
    (room,) = rooms_of(crowd)
    doors = [number for number, door in enumerate(PLAN.doors) if room in door.between]
    until(crowd, lambda: crowd._walkways.has_room(*where(crowd, room), 0.5))
    for door in doors:
        crowd.see_door(door, is_open=False)
    walk(crowd, 300)
    assert rooms_of(crowd) == [room]
    for door in doors:
        crowd.see_door(door, is_open=True)
    until(crowd, lambda: not rooms_of(crowd))
    for door in range(len(PLAN.doors)):
        crowd.see_door(door, is_open=False)
    walk(crowd, 600)
    assert not rooms_of(crowd)


def where(crowd, room):
    """Where somebody is in a room."""
    find = crowd._walkways.room_at
    (at,) = [(one.x, one.y) for one in crowd.people if find(one.x, one.y) == room]
    return at


def test_people_stop_now_and_then():
    crowd = crowd_of(10)
    walk(crowd, 600)
    stands = [person.vx == 0.0 and person.vy == 0.0 for person in crowd.people]
    assert any(stands)
    assert not all(stands)


@pytest.mark.parametrize("seed", range(4))
def test_who_ends_a_walk_in_a_doorway_visits_nobody(seed, monkeypatch):
    monkeypatch.setattr(person_module, "CHAT", 1.0)
    door = next(door for door in PLAN.doors if "r-5403" in door.between)
    crowd = crowd_of(1, seed=seed)
    goal = (door.at.x + 0.03, door.at.y)
    crowd.people[0] = person = Person(door.at.x - 0.1, door.at.y, speed=1.3, lane=0.5, way=[goal])
    walk(crowd, 1)
    assert crowd._walkways.room_at(person.x, person.y) == "r-5403"
    assert 0.0 < person.pause <= 60.0


@pytest.mark.parametrize("seed", range(2))
def test_nobody_walks_on_the_spot_for_long(seed):
    crowd = crowd_of(6, 2, seed)
    since = [(person.x, person.y) for person in crowd.people]
    idle = 0
    for _ in range(20):
        walk(crowd, 600)
        here = [(person.x, person.y) for person in crowd.people]
        moving = [person.pause <= 0.0 and bool(person.way) for person in crowd.people]
        near = [math.dist(*two) < 1.0 for two in zip(since, here, strict=True)]
        idle += sum(on_spot and walks for on_spot, walks in zip(near, moving, strict=True))
        since = here
    assert idle <= 4


def test_same_seed_same_walks():
    one, same, other = crowd_of(4, 2, 7), crowd_of(4, 2, 7), crowd_of(4, 2, 8)
    for crowd in (one, same, other):
        walk(crowd, 300)
    assert one.snapshot() == same.snapshot() != other.snapshot()


def test_a_person_stops_before_a_robot_then_walks_round_it():
    crowd, robot = crowd_of(1), Disc(MIDDLE, SOUTH, 0.305)
    crowd.people[0] = person = Person(
        MIDDLE, SOUTH + 4.0, speed=1.2, lane=0.5, way=[(MIDDLE, SOUTH - 4.0)]
    )
    gaps = []
    for tick in range(400):
        crowd.step(tick, (robot,), ())
        gaps.append(robot.gap(person.x, person.y, RADIUS))
        if person.y < SOUTH - 1.0:
            break
    waited = sum(abs(one - two) < 1e-9 for one, two in itertools.pairwise(gaps))
    assert waited > 15
    assert min(gaps) > 0.05
    assert person.y < SOUTH - 1.0


def test_one_who_overlooks_the_robot_walks_into_it_but_not_through_it(monkeypatch):
    monkeypatch.setattr(person_module, "ATTENTIVE", 0.0)
    world, person = facing(3.0)
    person.pause, person.way = 0.0, [(MIDDLE, SOUTH - 4.0)]
    readings = [world.step(0.0, 0.0) for _ in range(40)]
    truth = world.truth()
    assert any(reading.bump == 1 for reading in readings)
    assert (truth.people_touched, truth.people_hit) == (1, 0)
    assert truth.hardest_hit == 0.0
    assert math.dist((truth.x, truth.y), (MIDDLE, SOUTH)) < 0.05


def test_a_robot_that_drives_into_somebody_is_stopped_and_counted():
    world, person = facing(2.0)
    bumped = False
    for _ in range(60):
        bumped |= bool(world.step(0.5, 0.0).bump)
        if bumped:
            break
    truth = world.truth()
    assert (truth.people_touched, truth.people_hit) == (1, 1)
    assert truth.hardest_hit == pytest.approx(0.5, abs=0.02)
    assert world.reading.speed < 0.1
    standing = person.y
    for _ in range(15):
        world.step(0.0, 0.0)
    assert person.y > standing + 0.2
    assert world.truth().people_touched == 1


def test_creeping_against_somebody_is_no_hit():
    world, _ = facing(0.7)
    for _ in range(60):
        world.step(0.08, 0.0)
    truth = world.truth()
    assert truth.people_touched >= 1
    assert truth.people_hit == 0
    assert 0.0 < truth.hardest_hit <= 0.09


def test_one_touch_lasts_until_they_are_apart():
    met = PeopleMet()
    for ticks in (1, 2, 3, 5):
        for _ in range(ticks):
            met.pass_tick()
        met.touch(4, 0.3)
    assert (met.count, met.hits) == (2, 2)
    met.pass_tick()
    assert met.touched == [4]
    again = PeopleMet()
    again.restore(json.loads(json.dumps(met.snapshot())))
    assert again.snapshot() == met.snapshot()


def test_sonar_sees_a_person():
    world, _ = facing(1.5)
    ahead = np.median([world.step(0.0, 0.0).sonar[0] for _ in range(40)])
    assert ahead == pytest.approx(1.5 - RADIUS - XAVIER.sonar.ring_radius, abs=0.06)


def test_door_does_not_shut_on_a_cart_or_person():
    world = World(PLAN, people=1)
    door = next(door for door in PLAN.doors if door.name == "d-5303").at
    stand(world, door.x, door.y)
    assert world.set_door("r-5303", is_open=False) == ("d-5303", "r-5303", True)


def test_robot_is_not_put_upon_a_person():
    world, person = facing(2.0)
    with pytest.raises(NotFreeError, match="somebody or something stands there"):
        world.kidnap(person.x, person.y)


def test_carts_stand_beside_walls_and_not_in_the_mouths_of_corridors():
    spots = CartSpots(Walkways(PLAN), [], np.random.default_rng(1))
    found = [spots.find([], []) for _ in range(300)]
    off_walls = [segment_distances(WALLS, *spot).min() - CART_RADIUS for spot in found]
    assert max(off_walls) < 0.11


def test_carts_stand_clear_of_doors_and_each_other_until_taken_away():
    crowd = crowd_of(0, 8)
    discs = [cart.disc() for cart in crowd.carts]
    assert all(
        math.dist((disc.x, disc.y), (door.at.x, door.at.y)) > DOOR_CLEAR
        for disc in discs
        for door in PLAN.doors
    )
    assert all(a.gap(b.x, b.y, b.radius) > APART for i, a in enumerate(discs) for b in discs[:i])
    watched = discs[0]
    for cart in crowd.carts:
        cart.stays = 0.05
    walk(crowd, 1, robots=(Disc(watched.x + 1.0, watched.y, 0.305),))
    moved = [cart.disc() != disc for cart, disc in zip(crowd.carts, discs, strict=True)]
    assert not moved[0]
    assert sum(moved) >= 5


@settings(max_examples=4, deadline=None)
@given(st.integers(0, 200), st.integers(0, 1000))
def test_restored_crowd_goes_on_bit_for_bit(ticks, seed):
    straight, resumed = World(PLAN, seed, people=8, carts=2), World(PLAN, people=8, carts=2)
    for number, person in enumerate(straight._crowd.people):
        person.x, person.y = 5.5 + 0.8 * number, 10.0
    straight._crowd._list()
    straight.place_robot(4.6, 9.1, 0.3)
    stroll(straight, ticks, seed)
    resumed.restore(json.loads(json.dumps(straight.snapshot())))
    assert stroll(resumed, 120, seed + 1) == stroll(straight, 120, seed + 1)
    assert resumed.truth() == straight.truth()
    assert resumed.snapshot() == {**straight.snapshot(), "seed": resumed.seed}


def test_a_snapshot_from_before_there_were_people_leaves_them():
    world = World(PLAN, people=2)
    old = World(PLAN).snapshot()
    del old["crowd"], old["robots"]["xavier"]["people_met"]
    before = world.discs
    world.restore(old)
    assert world.discs == before


def test_too_many_for_a_small_floor():
    plan = FloorPlan(
        name="hut",
        spaces=(
            Space(
                name="hall",
                kind=SpaceKind.FOYER,
                low=Corner(x=0.0, y=0.0),
                high=Corner(x=5.0, y=5.0),
            ),
        ),
        doors=(),
        places={},
        start=Corner(x=1.0, y=1.0),
    )
    with pytest.raises(NoRoomError, match=r"people is 90, expected no more than the [0-9]+"):
        World(plan, people=90)
    with pytest.raises(NoRoomError, match=r"carts is 9, expected no more than the [0-9]+"):
        World(plan, carts=9)


@pytest.mark.parametrize(("kind", "width"), [(SpaceKind.ROOM, 6.0), (SpaceKind.CORRIDOR, 0.62)])
def test_where_nobody_can_walk_there_is_nobody(kind, width):
    corners = {"low": Corner(x=0.0, y=0.0), "high": Corner(x=20.0, y=width)}
    plan = FloorPlan(
        name="narrow",
        spaces=(Space(name="all", kind=kind, **corners),),
        doors=(),
        places={},
        start=Corner(x=1.0, y=0.31),
    )
    with pytest.raises(NoRoomError, match="people is 1, expected no more than the 0 that"):
        World(plan, people=1)
    with pytest.raises(NoRoomError, match="carts is 1, expected no more than the 0 that"):
        World(plan, carts=1)


def test_walkways_lead_through_openings_and_not_through_walls():
    ways = Walkways(PLAN)
    way = ways.way((5.0, 9.0), (20.0, 70.0), lane=0.5, radius=RADIUS)
    assert way[-1] == (20.0, 70.0)
    for (x0, y0), (x1, y1) in zip([(5.0, 9.0), *way], way, strict=False):
        for share in np.linspace(0.0, 1.0, 40):
            x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
            assert segment_distances(WALLS, x, y).min() > 0.2
    assert ways.way((-5.0, 0.0), (5.0, 9.0), lane=0.5, radius=RADIUS) == []
