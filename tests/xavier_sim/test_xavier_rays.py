"""One geometry: both casters, brute force and the physics see the same walls."""

from __future__ import annotations

import math

import numpy as np
import pymunk
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tca_bus import ConfigError
from xavier_sim.body import Disc, Physics
from xavier_sim.floors import WALL_RADIUS, build_geometry, load_floor
from xavier_sim.messages import Corner, Door, FloorPlan, Space, SpaceKind
from xavier_sim.sensors import RayCaster, _choice, make_caster
from xavier_sim.sensors._caster import PARALLEL
from xavier_sim.sensors._compiling import compiled

PLAN = load_floor()
GEOMETRY = build_geometry(PLAN)
SEGMENTS = np.concatenate([GEOMETRY.walls, GEOMETRY.doors])
REACH = 6.5
CULLED = RayCaster(SEGMENTS, REACH)
PHYSICS = Physics(GEOMETRY)
for DOOR in range(len(GEOMETRY.doors)):
    PHYSICS.set_door(DOOR, is_open=False)

points = st.sampled_from(PLAN.spaces).flatmap(
    lambda space: st.tuples(
        st.floats(space.low.x + 0.05, space.high.x - 0.05),
        st.floats(space.low.y + 0.05, space.high.y - 0.05),
    )
)
angles = st.floats(-math.pi, math.pi).map(lambda angle: round(angle, 6))


def brute(x, y, angle, segments=SEGMENTS):
    """Nearest hit of one ray by the textbook formula, segment by segment."""
    best, ux, uy = math.inf, np.cos(angle), np.sin(angle)
    for x0, y0, x1, y1 in segments:
        dx, dy, wx, wy = x1 - x0, y1 - y0, x0 - x, y0 - y
        cross = ux * dy - uy * dx
        if abs(cross) <= PARALLEL * math.hypot(dx, dy):
            continue
        distance, share = (wx * dy - wy * dx) / cross, (wx * uy - wy * ux) / cross
        if distance >= 0.0 and -1e-9 <= share <= 1.0 + 1e-9:
            best = min(best, distance)
    return best if best <= REACH else math.inf


def cast(x, y, angle, caster=CULLED):
    return float(caster.cast(np.array([[x, y]]), np.array([angle]))[0][0])


@settings(max_examples=150, deadline=None)
@given(points, angles)
def test_cull_agrees_with_brute_force_exactly(point, angle):
    assert cast(*point, angle) == brute(*point, angle)


def solid_distance(x, y, angle):
    """Nearest wall by pymunk's own segment query, in which walls are thick."""
    far = REACH + 1.0
    end = (x + far * math.cos(angle), y + far * math.sin(angle))
    hit = PHYSICS._space.segment_query_first((x, y), end, 0.0, pymunk.ShapeFilter())
    return math.inf if hit is None else hit.alpha * far


@settings(max_examples=300, deadline=None)
@given(points, angles)
def test_rays_agree_with_physics_within_the_wall(point, angle):
    """A thick wall is met earlier by its radius over the cosine, and round its ends."""
    thin, solid = cast(*point, angle), solid_distance(*point, angle)
    assert solid <= thin + 1e-6
    # Every point of a thick wall is within its radius of the wall's middle line.
    if solid <= REACH:
        x, y = point[0] + solid * math.cos(angle), point[1] + solid * math.sin(angle)
        assert CULLED.distances(x, y).min() <= WALL_RADIUS + 1e-6


@settings(max_examples=100, deadline=None)
@given(points, st.floats(0.1, 3.0), angles, st.floats(-0.3, 0.3), st.sampled_from([0.25, 0.35]))
def test_rays_meet_people_and_carts_where_the_physics_has_them(point, away, bearing, off, radius):
    (x, y), angle, far = point, bearing + off, 4.0
    disc = Disc(x + away * math.cos(bearing), y + away * math.sin(bearing), radius)
    PHYSICS.surround({0: disc})
    end = (x + far * math.cos(angle), y + far * math.sin(angle))
    hit = PHYSICS._shapes[0].segment_query((x, y), end)
    circles = np.array([[disc.x, disc.y, radius]])
    alone = RayCaster(np.empty((0, 4)), far)
    ray = alone.cast(np.array([[x, y]]), np.array([angle]), circles=circles)[0][0]
    PHYSICS.surround({})
    if disc.gap(x, y, 0.0) <= 1e-6:
        assert ray < 1e-6
    elif abs(away * abs(math.sin(off)) - radius) > 1e-6:
        solid = math.inf if hit is None else hit.alpha * far
        assert ray == pytest.approx(solid, abs=1e-6)


def test_closed_door_stops_rays():
    caster = RayCaster(SEGMENTS, REACH)
    index = len(GEOMETRY.walls) + GEOMETRY.door_rooms.index("r-5303")
    origin, west = np.array([[7.57, 23.165]]), np.array([math.pi])
    assert caster.cast(origin, west)[0][0] == pytest.approx(1.2)
    caster.switch(index, on=False)
    assert caster.cast(origin, west)[0][0] == pytest.approx(6.2)


def test_incidence_is_the_cosine_to_the_normal():
    origin = np.array([[7.57, 21.4]])
    _, cosine = CULLED.cast(origin, np.array([math.pi, math.pi - math.radians(40)]))
    assert cosine == pytest.approx([1.0, math.cos(math.radians(40))])


@pytest.fixture(scope="module")
def both():
    """The two casters; importing numba takes a second, which only this file's tests pay."""
    pytest.importorskip("numba")
    return RayCaster(SEGMENTS, REACH), make_caster("numba", SEGMENTS, REACH)


def assert_same(one, other, *where, **about):
    for mine, theirs in zip(one.cast(*where, **about), other.cast(*where, **about), strict=True):
        assert mine.tobytes() == theirs.tobytes()


crowds = st.lists(
    st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.05, 0.6)), max_size=4
).map(lambda rows: np.array(rows, dtype=float).reshape(-1, 3))
round_angles = st.integers(-16, 16).map(lambda eighth: eighth * math.pi / 8)


@settings(max_examples=150, deadline=None)
@given(points, st.lists(angles | round_angles, min_size=1, max_size=12), crowds, st.data())
def test_both_casters_agree_bit_for_bit(both, point, looks, crowd, data):
    start = data.draw(st.sampled_from([np.array(point), np.round(point)]))
    door = data.draw(st.integers(len(GEOMETRY.walls), len(SEGMENTS) - 1))
    for caster in both:
        caster.switch(door, on=len(looks) % 2 == 0)
    crowd = crowd + np.array([*point, 0.0])
    assert_same(*both, np.tile(start, (len(looks), 1)), np.array(looks), circles=crowd)


def test_both_casters_agree_outside_of_the_floor(both):
    looks = np.linspace(-math.pi, math.pi, 60)
    for x, y in ((-3.0, 20.0), (500.0, 20.0), (5.0, -2.0), (5.0, 1e6)):
        assert_same(*both, np.tile([[x, y]], (60, 1)), looks)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(*[st.integers(-12, 12)] * 4), min_size=1, max_size=12).map(
        lambda rows: [row for row in rows if row[:2] != row[2:]]
    ),
    st.tuples(st.integers(-12, 12), st.integers(-12, 12)),
    st.lists(angles | round_angles, min_size=1, max_size=8),
)
def test_both_casters_agree_among_slanting_walls(both, rows, point, looks):
    walls = np.array(rows, dtype=float).reshape(-1, 4) / 2
    casters = RayCaster(walls, REACH), type(both[1])(walls, REACH)
    assert_same(*casters, np.tile(np.array(point) / 2, (len(looks), 1)), np.array(looks))


def test_circles_stand_before_walls():
    west = np.array([[7.57, 20.0]]), np.array([math.pi])
    wall, _ = CULLED.cast(*west)
    person = np.array([[7.07, 20.1, 0.25], [9.0, 20.0, 0.5], [0.0, 20.0, 0.3]])
    distance, cosine = CULLED.cast(*west, circles=person)
    assert distance[0] == pytest.approx(0.5 - math.sqrt(0.25**2 - 0.1**2))
    assert cosine[0] == pytest.approx(math.sqrt(1 - 0.4**2))
    assert distance[0] < wall[0]
    assert CULLED.cast(*west, circles=person[1:])[0] == wall
    assert CULLED.cast(*west, circles=np.array([[7.6, 20.0, 0.25]]))[0] == 0.0


def test_what_cannot_be_cached_is_compiled_all_the_same():
    pytest.importorskip("numba")
    scope = {}
    exec("def twice(x):\n    return 2 * x", scope)  # of no file, so that no cache has a place
    fast = compiled(scope["twice"])
    assert fast is not scope["twice"]
    assert fast(2.5) == 5.0


def test_without_numba_numpy_casts(monkeypatch):
    monkeypatch.setattr(_choice, "can_compile", lambda: False)
    assert type(make_caster("auto", SEGMENTS, REACH)) is RayCaster
    with pytest.raises(ConfigError, match="rays is 'numba', expected numpy or auto"):
        make_caster("numba", SEGMENTS, REACH)


def test_no_walls_at_all(both):
    for caster in both:
        empty = type(caster)(np.empty((0, 4)), REACH)
        assert np.isinf(empty.cast(np.zeros((3, 2)), np.zeros(3))[0]).all()


def test_spaces_are_open_to_each_other_and_rooms_are_not():
    def space(name, kind, x):
        return Space(name=name, kind=kind, low=Corner(x=x, y=0), high=Corner(x=x + 4, y=3))

    plan = FloorPlan(
        name="two",
        spaces=(
            space("hall", SpaceKind.FOYER, 0),
            space("lounge", SpaceKind.LOUNGE, 4),
            space("r-1", SpaceKind.ROOM, 8),
        ),
        doors=(Door(name="d-1", between=("lounge", "r-1"), at=Corner(x=8, y=1.5)),),
        places={"r-1": Corner(x=8.7, y=1.5)},
        start=Corner(x=1, y=1),
    )
    geometry = build_geometry(plan)
    assert geometry.doors.tolist() == [[8.0, 1.05, 8.0, 1.95]]
    upright = sorted(row[:2] + row[3:] for row in geometry.walls.tolist() if row[0] == row[2])
    assert upright == [[0, 0, 3], [8, 0, 1.05], [8, 1.95, 3], [12, 0, 3]]
    assert sorted(row[1:] for row in geometry.walls.tolist() if row[1] == row[3]) == [
        [0, 12, 0],
        [3, 12, 3],
    ]
