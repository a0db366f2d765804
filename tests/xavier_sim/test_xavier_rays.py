"""One geometry: rays, brute force and the physics see the same walls."""

from __future__ import annotations

import math

import numpy as np
import pymunk
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from xavier_sim.body import BodyState, Physics
from xavier_sim.body._physics import ROBOT_CATEGORY
from xavier_sim.floors import WALL_RADIUS, build_geometry, load_floor
from xavier_sim.messages import Corner, Door, FloorPlan, Space, SpaceKind
from xavier_sim.profile import XAVIER
from xavier_sim.sensors import RayCaster

PLAN = load_floor()
GEOMETRY = build_geometry(PLAN)
SEGMENTS = np.concatenate([GEOMETRY.walls, GEOMETRY.doors])
REACH = 6.5
CULLED = RayCaster(SEGMENTS, REACH)
PHYSICS = Physics(GEOMETRY, XAVIER.base, BodyState(-100.0, -100.0, 0.0))

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
        if cross == 0.0:
            continue
        distance, share = (wx * dy - wy * dx) / cross, (wx * uy - wy * ux) / cross
        if distance >= 0.0 and -1e-9 <= share <= 1.0 + 1e-9:
            best = min(best, distance)
    return best if best <= REACH else math.inf


def cast(x, y, angle):
    return float(CULLED.cast(np.array([[x, y]]), np.array([angle]))[0][0])


@settings(max_examples=150, deadline=None)
@given(points, angles)
def test_cull_agrees_with_brute_force_exactly(point, angle):
    assert cast(*point, angle) == brute(*point, angle)


def solid_distance(x, y, angle):
    """Nearest wall by pymunk's own segment query, in which walls are thick."""
    far = REACH + 1.0
    end = (x + far * math.cos(angle), y + far * math.sin(angle))
    walls_only = pymunk.ShapeFilter(mask=pymunk.ShapeFilter.ALL_MASKS() ^ ROBOT_CATEGORY)
    hit = PHYSICS._space.segment_query_first((x, y), end, 0.0, walls_only)
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


def test_no_walls_at_all():
    caster = RayCaster(np.empty((0, 4)), REACH)
    assert np.isinf(caster.cast(np.zeros((3, 2)), np.zeros(3))[0]).all()


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
