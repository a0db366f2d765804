from __future__ import annotations

import json
import math
import re

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


def test_faults_of_a_map_are_named(tmp_path):
    def twice(raw):
        raw["spaces"].append(raw["spaces"][0])

    def nowhere(raw):
        raw["doors"][0]["between"] = ["r-5301", "corridor-53x"]

    def off_wall(raw):
        raw["doors"][0]["at"] = {"x": 0.0, "y": 0.0}

    def past_corner(raw):
        raw["doors"][0]["at"] = {"x": 6.314, "y": 17.8}

    def outside(raw):
        raw["places"]["r-5301"] = {"x": 90.0, "y": 0.0}

    def far_start(raw):
        raw["start"] = {"x": -50.0, "y": 0.0}

    def thin(raw):
        raw["spaces"][0]["high"] = raw["spaces"][0]["low"]

    assert "more than once" in problem(tmp_path, twice)
    assert "Did you mean 'corridor-53'" in problem(tmp_path, nowhere)
    assert "'d-5301' is in no wall between" in problem(tmp_path, off_wall)
    assert "'d-5301', 0.9 m wide, reaches beyond the wall" in problem(tmp_path, past_corner)
    assert "place of 'r-5301' lies outside" in problem(tmp_path, outside)
    assert "start (-50, 0) lies in no space" in problem(tmp_path, far_start)
    assert "low must lie below" in problem(tmp_path, thin)


def test_walls_that_cross_are_told(tmp_path):
    def crossing(raw):
        raw["spaces"][index_of(raw, "r-5301")]["high"]["y"] += 2.0

    said = problem(tmp_path, crossing)
    assert re.search(r"the walls of 'r-5301' and 'r-5303' cross: .* overlap by [\d.]+ m x", said)


def test_rooms_that_nobody_can_reach_are_told(tmp_path):
    def without_door(raw):
        raw["doors"] = [door for door in raw["doors"] if "r-5307" not in door["between"]]

    def with_a_narrow_one(raw):
        for door in raw["doors"]:
            door["width"] = 0.5 if "r-5307" in door["between"] else 0.9

    for change in (without_door, with_a_narrow_one):
        assert "nobody can reach 'r-5307' from 'foyer'" in problem(tmp_path, change)


def test_a_map_of_a_continent_is_none_of_a_floor(tmp_path):
    def endless(raw):
        raw["spaces"][index_of(raw, "corridor-53")]["high"]["y"] = 1e9

    def campus(raw):
        for corner in ("low", "high"):
            raw["spaces"][index_of(raw, "r-5301")][corner]["x"] -= 5000.0

    said = problem(tmp_path, campus)
    assert re.search(r"the floor spans 50\d\d.* m x \d+.* m, expected 100000 m² at most", said)

    said = problem(tmp_path, endless)
    assert "space 'corridor-53' reaches 1e+09 m from 0, expected 10000 at most" in said


def test_a_door_leads_from_one_space_to_another(tmp_path):
    def to_itself(raw):
        raw["doors"][0]["between"] = ["r-5301", "r-5301"]

    assert "leads from 'r-5301' to itself" in problem(tmp_path, to_itself)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_coordinates_are_finite(tmp_path, value):
    def endless(raw):
        raw["places"]["r-5301"]["x"] = value

    assert "places.r-5301.x: Input should be a finite number" in problem(tmp_path, endless)


def index_of(raw, name):
    return next(number for number, space in enumerate(raw["spaces"]) if space["name"] == name)


@settings(deadline=None, max_examples=25)
@given(st.floats(5, 20), st.floats(10, 75))
def test_clearance_is_the_distance_to_the_nearest_wall(x, y):
    walls = SURVEYED.walls
    ends = np.linspace(walls[:, :2], walls[:, 2:], 200)
    sampled = np.hypot(ends[..., 0] - x, ends[..., 1] - y).min()
    assert clearance_of(walls, x, y) <= sampled + 1e-9
    assert clearance_of(walls, x, y) >= sampled - 0.15
