"""Floor plans: the one that comes with the package, and all the ways in which one can be wrong."""

from __future__ import annotations

import itertools

import pytest
import yaml

from xavier_sim.floors import FloorError, load_floor, plan_to_yaml, survey_floor
from xavier_sim.floors._floor import FLOORS
from xavier_sim.messages import Corner, SpaceKind


@pytest.fixture
def plan_data():
    return yaml.safe_load((FLOORS / "wean5.yaml").read_text())


def load(tmp_path, data):
    file = tmp_path / "floor.yaml"
    file.write_text(data if isinstance(data, str) else yaml.safe_dump(data))
    return load_floor(str(file))


def entry(data, section, name):
    return next(item for item in data[section] if item["name"] == name)


def test_papers_places_are_kept():
    places = load_floor().places
    assert places["r-5303"] == Corner(x=5.67, y=23.165)
    assert places["r-5313"] == Corner(x=5.67, y=41.15)


def test_odd_rooms_stand_in_line():
    places = load_floor().places
    odd = [places[f"r-{number}"] for number in range(5301, 5317, 2)]
    assert {place.x for place in odd} == {5.67}
    steps = [b.y - a.y for a, b in itertools.pairwise(odd)]
    assert steps == pytest.approx([3.597] * 7)


def test_floor_has_sixty_rooms_with_a_door_each():
    plan = load_floor()
    rooms = {space.name for space in plan.spaces if space.kind is SpaceKind.ROOM}
    assert len(rooms) == 60
    assert sorted(door.between[0] for door in plan.doors) == sorted(rooms)
    assert {door.width for door in plan.doors} == {0.9}


def test_unknown_floor_names_near_match():
    with pytest.raises(FloorError, match="Did you mean 'wean5'"):
        load_floor("wean4")
    with pytest.raises(FloorError, match="expected a floor plan file or one of wean5"):
        load_floor("wean" * 1000)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("? [a, b]\n: 1\n", "line 1, column 3 is 'found unhashable key', expected valid YAML"),
        (f"name: {'[' * 5000}{']' * 5000}\n", "file is 'nested without end'"),
    ],
)
def test_yaml_that_is_no_plain_mapping(tmp_path, text, says):
    with pytest.raises(FloorError, match=says):
        load(tmp_path, text)


def test_yaml_error_names_line_and_column(tmp_path):
    with pytest.raises(FloorError, match=r"floor\.yaml: line 2, column \d+"):
        load(tmp_path, "name: x\nspaces: [{]\n")


def test_no_mapping(tmp_path):
    with pytest.raises(FloorError, match="expected a mapping"):
        load(tmp_path, "- 1\n- 2\n")


def test_binary_file(tmp_path):
    file = tmp_path / "floor.yaml"
    file.write_bytes(b"\xff\xfe\x00\x80")
    says = "file is 'no text from byte 0 on', expected a readable UTF-8 text file"
    with pytest.raises(FloorError, match=says):
        load_floor(str(file))


def test_a_field_that_there_is_not(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5303")["colour"] = "red"
    says = r"doors\.1\.colour \(d-5303\) is 'red', expected no field of that name"
    with pytest.raises(FloorError, match=says):
        load(tmp_path, plan_data)


def test_wrong_type_names_item_and_field(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5303")["width"] = "wide"
    with pytest.raises(FloorError, match=r"doors\.1\.width \(d-5303\) is 'wide'"):
        load(tmp_path, plan_data)


def test_name_twice(tmp_path, plan_data):
    entry(plan_data, "spaces", "r-5305")["name"] = "r-5303"
    with pytest.raises(FloorError, match="name of a space is 'r-5303', expected a name"):
        load(tmp_path, plan_data)


def test_door_name_twice(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5305")["name"] = "d-5303"
    with pytest.raises(FloorError, match="name of a door is 'd-5303'"):
        load(tmp_path, plan_data)


def test_overlapping_spaces(tmp_path, plan_data):
    entry(plan_data, "spaces", "r-5303")["high"]["y"] += 0.2
    with pytest.raises(FloorError, match="overlap of spaces r-5303 and r-5305"):
        load(tmp_path, plan_data)


def test_inverted_space(tmp_path, plan_data):
    space = entry(plan_data, "spaces", "lounge")
    space["low"], space["high"] = space["high"], space["low"]
    with pytest.raises(FloorError, match="space lounge: extent in x"):
        load(tmp_path, plan_data)


def test_door_off_its_wall(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5303")["at"]["x"] += 0.3
    with pytest.raises(FloorError, match=r"door d-5303: at is '\(6.67, 23.165\)'"):
        load(tmp_path, plan_data)


def test_door_beyond_the_shared_wall(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5303")["at"]["y"] = 21.4
    with pytest.raises(FloorError, match="the wall that r-5303 and corridor-53 share"):
        load(tmp_path, plan_data)


def test_door_between_spaces_that_do_not_touch(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5303")["between"] = ["r-5303", "corridor-54"]
    with pytest.raises(FloorError, match="expected two spaces that share a wall"):
        load(tmp_path, plan_data)


def test_door_of_unknown_space(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5303")["between"] = ["r-5303", "coridor-53"]
    with pytest.raises(FloorError, match="Did you mean 'corridor-5"):
        load(tmp_path, plan_data)


def test_place_outside_its_room(tmp_path, plan_data):
    plan_data["places"]["r-5303"]["x"] = 7.5
    with pytest.raises(FloorError, match=r"place of r-5303 is '\(7.5, 23.165\)'"):
        load(tmp_path, plan_data)


def test_place_of_unknown_room(tmp_path, plan_data):
    plan_data["places"]["r-5999"] = {"x": 1.0, "y": 1.0}
    with pytest.raises(FloorError, match="place is 'r-5999'"):
        load(tmp_path, plan_data)


def test_room_without_place(tmp_path, plan_data):
    del plan_data["places"]["r-5303"]
    with pytest.raises(FloorError, match="place of r-5303"):
        load(tmp_path, plan_data)


def test_room_nobody_can_reach(tmp_path, plan_data):
    plan_data["doors"].remove(entry(plan_data, "doors", "d-5313"))
    with pytest.raises(FloorError, match="way to r-5313 is 'none'"):
        load(tmp_path, plan_data)


def test_start_outside(tmp_path, plan_data):
    plan_data["start"] = {"x": -50.0, "y": 0.0}
    with pytest.raises(FloorError, match="start is"):
        load(tmp_path, plan_data)


def test_survey_moves_walls_but_not_places():
    plan = load_floor()
    surveyed = survey_floor(plan, sigma=0.03, seed=4)
    assert surveyed.places == plan.places
    pairs = zip(surveyed.spaces, plan.spaces, strict=True)
    errors = [new.low.x - old.low.x for new, old in pairs]
    assert any(abs(error) > 0.005 for error in errors)
    assert all(abs(error) <= 0.076 for error in errors)


def test_survey_is_repeatable_and_survives_yaml(tmp_path):
    surveyed = survey_floor(load_floor(), sigma=0.03, seed=4)
    assert surveyed == survey_floor(load_floor(), sigma=0.03, seed=4)
    assert load(tmp_path, plan_to_yaml(surveyed)) == surveyed


@pytest.mark.parametrize("name", ["5: the west, #2", "off", "1.5", "Fünfter Stock", "'", "a\nb"])
def test_any_name_survives_yaml(tmp_path, name):
    plan = load_floor().model_copy(update={"name": name})
    assert load(tmp_path, plan_to_yaml(plan)) == plan


def test_a_room_may_be_called_like_a_truth_value(tmp_path, plan_data):
    text = yaml.safe_dump(plan_data).replace("r-5303", "'off'")
    plan = load(tmp_path, text)
    assert "off" in plan.places
    assert load(tmp_path, plan_to_yaml(plan)) == plan


def test_perfect_survey_changes_nothing_but_rounding():
    plan = load_floor()
    surveyed = survey_floor(plan, sigma=0.0, seed=4)
    for new, old in zip(surveyed.spaces, plan.spaces, strict=True):
        assert new.high.y == pytest.approx(old.high.y, abs=0.0006)


def test_door_with_the_name_of_a_space(tmp_path, plan_data):
    entry(plan_data, "doors", "d-5303")["name"] = "lounge"
    with pytest.raises(FloorError, match="name of a door is 'lounge', expected a name that no sp"):
        load(tmp_path, plan_data)


def test_place_given_twice(tmp_path):
    text = (FLOORS / "wean5.yaml").read_text()
    place = next(line for line in text.splitlines() if line.startswith("  r-5303:"))
    with pytest.raises(FloorError, match=r"line \d+, column 3 is 'a second r-5303', expected each"):
        load(tmp_path, text.replace(place, f"{place}\n{place}"))


def test_two_doors_in_one_piece_of_wall(tmp_path, plan_data):
    door = dict(entry(plan_data, "doors", "d-5303"), name="d-5303b")
    door["at"] = {"x": door["at"]["x"], "y": door["at"]["y"] + 0.5}
    plan_data["doors"].append(door)
    with pytest.raises(FloorError, match=r"door d-5303b: at is .* expected a place beside door d-"):
        load(tmp_path, plan_data)


@pytest.mark.parametrize(
    ("item", "point"), [("start", {"x": 4.2, "y": 12.0}), ("charger", {"x": 7.57, "y": 8.6})]
)
def test_the_robot_fits_where_it_is_to_stand(tmp_path, plan_data, item, point):
    plan_data[item] = point
    says = rf"{item} is '\(.*\)', expected a point at least 0.305 m from any wall, not 0\.[12] m"
    with pytest.raises(FloorError, match=says):
        load(tmp_path, plan_data)


def test_a_place_so_near_to_a_wall_that_the_robot_does_not_fit(tmp_path, plan_data):
    plan_data["places"]["r-5305"]["x"] = 6.2
    plan_data["places"]["r-5305"]["y"] += 0.6
    with pytest.raises(FloorError, match="place of r-5305 is"):
        load(tmp_path, plan_data)


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [
        (("start", "x"), float("nan"), "start.x is 'nan', expected a finite number"),
        (("start_heading",), float("inf"), "start_heading is 'inf', expected a finite number"),
        (("spaces", 3, "high", "x"), 1e12, "high.x is '1e.12', expected at most 10000 m from 0"),
    ],
)
def test_numbers_that_are_none_and_absurd_ones(tmp_path, plan_data, field, value, says):
    inner = plan_data
    for key in field[:-1]:
        inner = inner[key]
    inner[field[-1]] = value
    with pytest.raises(FloorError, match=says):
        load(tmp_path, plan_data)
