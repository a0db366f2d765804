"""The camera: which plates there are, which it sees, what it reads, and how sure it is."""

from __future__ import annotations

import math

import pytest

from xavier_sim.floors import build_geometry, load_floor, space_at
from xavier_sim.messages import SpaceKind
from xavier_sim.profile import CameraProfile
from xavier_sim.sensors import Camera
from xavier_sim.sensors._camera import NOTHING, door_plates
from xavier_sim.world import World

PLAN = load_floor()
GEOMETRY = build_geometry(PLAN)
SHARP = CameraProfile(blank=0.0, blank_growth=0.0, misread=0.0, misread_growth=0.0)
PLACE = PLAN.places["r-5303"]
DOOR = next(door for door in PLAN.doors if door.name == "d-5303").at


def unhindered(_x, _y):
    return True


def sharp(seed=1):
    return Camera(GEOMETRY, SHARP, seed)


def test_every_door_has_a_plate_on_both_faces_of_its_wall():
    plates = door_plates(GEOMETRY)
    assert len(plates) == 2 * len(PLAN.doors)
    for plate in plates:
        off = 0.1
        before = space_at(PLAN, plate.x + off * plate.normal_x, plate.y + off * plate.normal_y)
        behind = space_at(PLAN, plate.x - off * plate.normal_x, plate.y - off * plate.normal_y)
        assert SpaceKind.ROOM in {before.kind, behind.kind}
        assert plate.text in {before.name, behind.name}


@pytest.mark.parametrize("room", sorted(PLAN.places))
def test_whoever_stands_inside_a_door_reads_that_room(room):
    world = World(PLAN, seed=1)
    place = PLAN.places[room]
    door = next(door for door in PLAN.doors if room in door.between).at
    world.place_robot(place.x, place.y, math.atan2(place.y - door.y, place.x - door.x))
    readings = set()
    for tick in range(30):
        look = world.robot.look(tick)
        readings |= {look.text} if look.confidence > 0.97 else set()
    assert readings == {room}


@pytest.mark.parametrize(
    ("x", "y", "theta", "text"),
    [
        (DOOR.x + 1.2, DOOR.y, math.pi, "r-5303"),
        (DOOR.x + 0.3, DOOR.y + 1.6, math.pi, None),
        (DOOR.x + 2.3, DOOR.y, math.pi, None),
        (7.57, 12.0, 0.0, None),
    ],
)
def test_plates_are_read_from_near_and_not_too_much_askance(x, y, theta, text):
    assert sharp().look(x, y, theta, 0, unhindered).text == text


def test_what_is_behind_the_head_is_not_seen():
    plate = next(plate for plate in door_plates(GEOMETRY) if plate.text == "r-5303")
    x, y = plate.x + plate.normal_x, plate.y + plate.normal_y
    away = math.atan2(plate.normal_y, plate.normal_x)
    camera = Camera(GEOMETRY, SHARP.model_copy(update={"farthest": 1.1}), 1)
    assert camera.look(x, y, away, 0, unhindered) == NOTHING
    assert camera.look(x, y, away + 0.5, 0, unhindered).text == "r-5303"


def test_walls_hide_plates():
    assert sharp().look(PLACE.x, PLACE.y, math.pi, 0, lambda x, y: False) == NOTHING


def test_the_same_seed_and_tick_see_the_same_again():
    one, two, other = (Camera(GEOMETRY, CameraProfile(), seed) for seed in (1, 1, 2))
    looks = [
        [camera.look(PLACE.x, PLACE.y, math.pi, tick, unhindered) for tick in range(300)]
        for camera in (one, two, other)
    ]
    assert looks[0] == looks[1]
    assert looks[0] != looks[2]
    assert {look.text for look in looks[0]} > {None, "r-5303"}


def test_readings_are_as_often_right_as_their_confidence_says():
    poor = CameraProfile(misread=0.2, misread_growth=0.0)
    camera = Camera(GEOMETRY, poor, 3)
    looks = [camera.look(PLACE.x, PLACE.y, math.pi, tick, unhindered) for tick in range(3000)]
    read = [look for look in looks if look.text is not None]
    right = sum(look.text == "r-5303" for look in read) / len(read)
    said = sum(look.confidence for look in read) / len(read)
    assert right == pytest.approx(said, abs=0.03)
    assert {len(look.text) for look in read} == {len("r-5303")}


def test_a_camera_goes_on_from_its_snapshot():
    camera, again = Camera(GEOMETRY, CameraProfile(), 3), sharp()
    camera.is_on = False
    again.restore(camera.snapshot())
    assert not again.is_on
    assert again.snapshot() == camera.snapshot()
