"""What a map is refused for: file, item, value, and what was expected instead."""

from __future__ import annotations

import json

import pytest

from navigate.maps import MapError, load_plan
from xavier_sim.floors import load_floor, survey_floor

WEAN = load_plan().model_dump(mode="json")


@pytest.fixture
def raw():
    return json.loads(json.dumps(WEAN))


@pytest.fixture
def refusal(tmp_path, raw):
    """What is said of the map as it was changed, without the file that it begins with."""

    def refuse():
        path = tmp_path / "floor.yaml"
        path.write_text(json.dumps(raw))
        with pytest.raises(MapError) as caught:
            load_plan(path)
        assert caught.value.exit_code == 2
        text = str(caught.value)
        assert text.startswith(f"map {path}: ")
        return text.removeprefix(f"map {path}: ")

    return refuse


def entry(raw, section, name):
    return next(one for one in raw[section] if one["name"] == name)


def test_a_map_without_spaces(raw, refusal):
    raw |= {"spaces": [], "doors": [], "places": {}}
    assert refusal().startswith("number of spaces is '0', expected 1 or more")


@pytest.mark.parametrize("kind", ["space", "door"])
def test_a_name_that_stands_twice(raw, refusal, kind):
    one = raw[f"{kind}s"][0]
    raw[f"{kind}s"].append(one)
    says = f"name of a {kind} is {one['name']!r}, expected a name that is used only once"
    assert says in refusal()


def test_a_door_with_the_name_of_a_space(raw, refusal):
    raw["doors"][0]["name"] = "lounge"
    assert refusal() == "name of a door is 'lounge', expected a name that no space has"


def test_a_space_that_is_too_thin(raw, refusal):
    hall = entry(raw, "spaces", "corridor-53")
    hall["high"]["x"] = hall["low"]["x"] + 0.5
    says = "extent of space 'corridor-53' in x (6.314 to 6.814) is '0.5', expected 0.7 m or more"
    assert says in refusal()


def test_a_space_that_is_turned_inside_out(raw, refusal):
    room = entry(raw, "spaces", "r-5303")
    room["low"]["y"], room["high"]["y"] = room["high"]["y"], room["low"]["y"]
    says = "extent of space 'r-5303' in y (24.941 to 21.433) is '-3.508', expected 0.7 m or more"
    assert says in refusal()


def test_walls_that_cross(raw, refusal):
    entry(raw, "spaces", "r-5301")["high"]["y"] += 2.0
    says = "overlap of spaces 'r-5301' and 'r-5303' is '4.94 m x 2.00 m', expected walls that do "
    assert f"{says}not cross by more than 0.3 m" in refusal()


def test_a_corner_at_the_end_of_the_world(raw, refusal):
    entry(raw, "spaces", "corridor-53")["high"]["y"] = 1e9
    says = "corner of space 'corridor-53' is '1e+09 m from 0', expected 10000 m at most"
    assert says in refusal()


def test_a_map_of_a_campus(raw, refusal):
    for corner in ("low", "high"):
        entry(raw, "spaces", "r-5301")[corner]["x"] -= 5000.0
    says = "extent of the floor is '5024.85 m x 69.287 m', expected 100000 m² at most"
    assert says in refusal()


def test_a_door_to_an_unknown_space(raw, refusal):
    entry(raw, "doors", "d-5301")["between"] = ["r-5301", "corridor-53x"]
    says = "door 'd-5301': between is 'corridor-53x', expected the name of a space. Did you mean"
    assert f"{says} 'corridor-53'" in refusal()


def test_a_door_to_where_it_comes_from(raw, refusal):
    entry(raw, "doors", "d-5301")["between"] = ["r-5301", "r-5301"]
    says = "door 'd-5301': between is 'r-5301, r-5301', expected two different spaces"
    assert refusal() == says


def test_a_door_off_its_wall(raw, refusal):
    entry(raw, "doors", "d-5301")["at"] = {"x": 0.0, "y": 1.5}
    says = "door 'd-5301': at is '(0, 1.5)', expected a point of the wall between "
    assert says in refusal()


def test_a_door_that_ends_beyond_its_wall(raw, refusal):
    entry(raw, "doors", "d-5301")["at"] = {"x": 6.314, "y": 17.8}
    says = "door 'd-5301': width is '0.9', expected one with which the door at (6.314, 17.8) ends"
    assert f"{says} within the wall between " in refusal()


def test_two_doors_in_one_gap(raw, refusal):
    door = entry(raw, "doors", "d-5303")
    x, y = door["at"].values()
    raw["doors"].append({**door, "name": "d-5303b", "at": {"x": x, "y": round(y + 0.5, 3)}})
    says = f"door 'd-5303b': at is '({x:g}, {y + 0.5:g})', expected a point beside door 'd-5303'"
    assert refusal() == says


def test_a_place_of_no_space(raw, refusal):
    raw["places"]["r-53033"] = {"x": 5.67, "y": 23.165}
    says = "name of a place is 'r-53033', expected the name of a space. Did you mean 'r-5303'"
    assert says in refusal()


def test_a_place_outside_of_its_room(raw, refusal):
    raw["places"]["r-5301"] = {"x": 90.0, "y": 0.0}
    assert refusal() == "place of 'r-5301' is '(90, 0)', expected a point inside 'r-5301'"


def test_a_room_without_a_place(raw, refusal):
    del raw["places"]["r-5301"]
    assert refusal() == "place of 'r-5301' is 'None', expected a point inside the room"


def test_a_place_where_the_robot_does_not_fit(raw, refusal):
    raw["places"]["r-5303"] = {"x": 5.67, "y": 24.8}
    says = "place of 'r-5303' is '(5.67, 24.8)', expected a point 0.305 m or more from any wall"
    assert refusal() == f"{says}, not 0.141"


def test_a_start_in_no_space(raw, refusal):
    raw["start"] = {"x": -50.0, "y": 0.0}
    assert refusal() == "start is '(-50, 0)', expected a point inside a space"


def test_a_start_where_the_robot_does_not_fit(raw, refusal):
    raw["start"] = {"x": 4.1, "y": 12.0}
    says = "start is '(4.1, 12)', expected a point 0.305 m or more from any wall, not 0.104"
    assert refusal() == says


def test_a_room_that_no_door_leads_to(raw, refusal):
    raw["doors"] = [door for door in raw["doors"] if "r-5307" not in door["between"]]
    says = "way to 'r-5307' is 'none', expected a door wider than 0.61 m, or open floor, on the way"
    assert refusal() == f"{says} from 'foyer'"


def test_a_room_whose_door_is_too_narrow(raw, refusal):
    for door in raw["doors"]:
        door["width"] = 0.5 if "r-5307" in door["between"] else 0.9
    assert refusal().startswith("way to 'r-5307' is 'none', expected a door wider than 0.61 m")


def test_what_is_wrong_is_told_all_at_once(raw, refusal):
    del raw["places"]["r-5301"]
    raw["start"] = {"x": -50.0, "y": 0.0}
    assert refusal().count(", expected ") == 2


def accepted(tmp_path, plan):
    path = tmp_path / "floor.yaml"
    path.write_text(plan if isinstance(plan, str) else plan.model_dump_json())
    return load_plan(path)


def test_a_survey_may_bring_walls_and_doors_nearer(tmp_path, raw):
    raw["places"]["r-5303"] = {"x": 5.67, "y": 24.941 - 0.305 + 0.08}
    beside = entry(raw, "doors", "d-5303")
    at = {"x": beside["at"]["x"], "y": beside["at"]["y"] + 0.75}
    raw["doors"].append({**beside, "name": "d-5303b", "at": at})
    plan = accepted(tmp_path, json.dumps(raw))
    assert plan.places["r-5303"].y == raw["places"]["r-5303"]["y"]
    assert plan.doors[-1].name == "d-5303b"


@pytest.mark.parametrize("seed", range(3))
def test_what_the_survey_makes_of_a_floor_is_a_map(tmp_path, seed):
    plan = survey_floor(load_floor("wean5"), sigma=0.06, seed=seed)
    assert accepted(tmp_path, plan) == plan
