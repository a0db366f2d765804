from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from navigate_loop import true_plan

from navigate.maps import Floor, MapError, UnknownRoomError, frame, load_plan
from navigate.maps._floor import clearance_of
from navigate.maps._floorfile import own_maps
from navigate.maps._walls import wall_segments
from xavier_sim.floors import build_geometry

SURVEYED = Floor(load_plan())
TRUE = Floor(true_plan())


def written(tmp_path, change):
    raw = load_plan().model_dump(mode="json")
    change(raw)
    path = tmp_path / "floor.yaml"
    path.write_text(json.dumps(raw))
    return path


def problem(tmp_path, change):
    with pytest.raises(MapError) as caught:
        load_plan(written(tmp_path, change))
    assert caught.value.exit_code == 2
    return str(caught.value)


def test_the_package_has_a_map_of_sixty_rooms():
    assert "wean5" in own_maps()
    assert len(SURVEYED.places) == 60 == len(SURVEYED.doors)


def test_the_papers_coordinates_are_read_as_centimetres():
    location = TRUE.location("r-5303")
    assert (location.x, location.y) == (567.0, 2316.5)


def test_walls_of_a_true_plan_are_those_that_the_simulator_builds():
    theirs = build_geometry(true_plan()).walls
    ours = wall_segments(true_plan())
    for x0, y0, x1, y1 in theirs:
        assert clearance_of(ours, (x0 + x1) / 2, (y0 + y1) / 2) < 1e-6
    for x0, y0, x1, y1 in ours:
        assert clearance_of(theirs, (x0 + x1) / 2, (y0 + y1) / 2) < 1e-6


def test_survey_errors_do_not_close_or_open_the_floor():
    # The surveyed plan has each wall between rooms twice, so it is compared by its passages.
    names = {passage.name for passage in TRUE.passages}
    assert names == {passage.name for passage in SURVEYED.passages}
    assert all(SURVEYED.free(*place) for place in SURVEYED.places.values())


def test_a_door_has_a_frame_that_looks_from_its_first_space_into_its_second():
    door = SURVEYED.doors["d-5303"]
    into = SURVEYED.spaces[door.spaces[1]]
    middle = ((into.low.x + into.high.x) / 2, door.centre[1])
    assert frame(door, *middle)[0] > 0
    x0, y0, x1, y1 = door.segment()
    assert math.isclose(math.dist((x0, y0), (x1, y1)), door.width)
    assert frame(door, x0, y0)[1] > 0 > frame(door, x1, y1)[1]


def test_unknown_rooms_come_with_near_matches():
    with pytest.raises(UnknownRoomError, match=r"no room 'r-53033'.*'r-5303'"):
        SURVEYED.place("r-53033")
    assert SURVEYED.place("R-5303") == SURVEYED.place("r-5303")


@given(st.floats(-5, 35), st.floats(0, 85))
def test_every_point_has_a_nearest_space(x, y):
    space = SURVEYED.space_nearest(x, y)
    holding = SURVEYED.space_at(x, y)
    assert holding is None or space == holding


def test_open_floor_around_a_point_is_what_opens_on_its_space_and_is_near():
    floor = SURVEYED
    crossing = next(one for one in floor.passages if not one.door)
    x, y = crossing.centre
    assert {one.name for one in floor.open_around(x, y, within=0.5)} >= set(crossing.spaces)
    for name, (x, y) in floor.places.items():
        assert [one.name for one in floor.open_around(x, y, within=9.0)] == [name]
    corridor = floor.spaces["corridor-53"]
    x, y = (corridor.low.x + corridor.high.x) / 2, (corridor.low.y + corridor.high.y) / 2
    assert floor.open_around(x, y, within=1.0) == [corridor]
    assert len(floor.open_around(x, y, within=99.0)) > 1


@given(st.floats(-20, 60), st.floats(-20, 100))
def test_the_space_of_a_point_is_the_smallest_of_all_that_hold_it(x, y):
    def holds(space):
        return space.low.x <= x <= space.high.x and space.low.y <= y <= space.high.y

    def area(space):
        return (space.high.x - space.low.x) * (space.high.y - space.low.y)

    holding = [space for space in SURVEYED.plan.spaces if holds(space)]
    assert SURVEYED.space_at(x, y) == min(holding, key=area, default=None)


def test_missing_map_names_near_ones():
    with pytest.raises(MapError, match="'wean5'"):
        load_plan("wean")
    with pytest.raises(MapError, match="no such file, and no map of that name"):
        load_plan("wean" * 1000)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (b"{", "cannot be read as YAML"),
        (b"places:\n  a: 1\n  b: 2\n  a: 3\n", "'a' stands twice in one mapping, again in line 4"),
        (b"\xff\xfe\x00", "no UTF-8"),
        (b"- 1\n- 2\n", r"the document: .*, got '\[1, 2\]'"),
        (b"name: x\n", "Field required"),
        (b"? [a, b]\n: 1\n", "cannot be read as YAML: .* unhashable key"),
    ],
)
def test_rubbish_is_told_from_a_map(tmp_path, text, says):
    path = tmp_path / "floor.yaml"
    path.write_bytes(text)
    with pytest.raises(MapError, match=says):
        load_plan(path)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_coordinates_are_finite(tmp_path, value):
    def endless(raw):
        raw["places"]["r-5301"]["x"] = value

    assert "places.r-5301.x: Input should be a finite number" in problem(tmp_path, endless)


@settings(deadline=None, max_examples=25)
@given(st.floats(5, 20), st.floats(10, 75))
def test_clearance_is_the_distance_to_the_nearest_wall(x, y):
    walls = SURVEYED.walls
    ends = np.linspace(walls[:, :2], walls[:, 2:], 200)
    sampled = np.hypot(ends[..., 0] - x, ends[..., 1] - y).min()
    assert clearance_of(walls, x, y) <= sampled + 1e-9
    assert clearance_of(walls, x, y) >= sampled - 0.15
