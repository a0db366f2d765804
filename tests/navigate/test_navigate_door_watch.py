"""Doors that the robot passes on its way elsewhere are remembered as they stood."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from navigate_loop import Loop

from navigate.body import LIDAR, RING_RADIUS, Percept, Sight
from navigate.driving import DoorWatch
from navigate.driving._doorwatch import MOST_CELLS
from navigate.freezing import freeze, thaw
from navigate.maps import Floor, load_plan
from navigate.routes import Hindrances, Memory, Planner
from xavier_sim.messages import LIDAR_BEAMS

FLOOR = Floor(load_plan())
DOOR = FLOOR.doors["d-5307"]
BEFORE, HALF, ROOM = 1.2, DOOR.width / 2, 4.0
ALL = (1 << 24) - 1
OFFSETS = np.radians(np.linspace(-11.25, 11.25, 9))


def pose(along, before=BEFORE):
    """Beside the door, looking along the wall that the door is in."""
    (x, y), (nx, ny) = DOOR.centre, DOOR.normal
    turned = math.atan2(ny, nx) - math.pi / 2
    at = x - before * nx + along * ny, y - before * ny - along * nx
    return (*at, turned)


def beam(x, look, *, shut, jambs):
    """How far it is from the robot's side to the wall, or the end of the room behind the door."""
    if math.cos(look) < 0.1:
        return math.inf
    crossing = x + BEFORE * math.tan(look)
    through = not shut and jambs[0] < crossing < jambs[1]
    return (BEFORE + ROOM if through else BEFORE) / math.cos(look)


def senses(along, *, shut, off=0.0, company=None, lidar=False):
    """What a robot senses there that is ``off`` metres farther along than it believes."""
    jambs = (-HALF, HALF)
    ring = np.full(24, np.inf)
    for sonar in range(24):
        look = -math.pi / 2 + sonar * math.tau / 24
        reached = [beam(-along - off, look + o, shut=shut, jambs=jambs) for o in OFFSETS]
        ring[sonar] = min(reached) - RING_RADIUS
    if company is not None:
        ring[5:8] = company
    if not lidar:
        return Percept(ring, ALL, ring, ALL)
    looks = -math.pi / 2 + LIDAR.bearings
    ranges = np.array([beam(-along - off, look, shut=shut, jambs=jambs) for look in looks])
    sight = Sight(ranges, np.zeros((LIDAR_BEAMS, 2)), ring)
    silent = np.full(24, np.inf)
    return Percept(silent, 0, silent, 0, ((LIDAR, sight),))


def pass_by(watch, *, believed=pose, **there):
    """Drive past the door at half a metre a second, with a sonar ring of 2.5 Hz."""
    judged = []
    for tick, along in enumerate(np.arange(-1.5, 1.5, 0.2)):
        judged += watch.look(believed(along), senses(along, **there), 0.4 * tick)
    return judged


@pytest.mark.parametrize("lidar", [False, True])
@pytest.mark.parametrize("shut", [False, True])
def test_a_door_that_is_passed_is_judged_as_it_stands(shut, lidar):
    watch = DoorWatch(FLOOR.doors.values())
    assert pass_by(watch, shut=shut, lidar=lidar) == [(DOOR.name, not shut)]
    assert pass_by(watch, shut=shut, lidar=lidar) == [(DOOR.name, not shut)]


@pytest.mark.parametrize("lidar", [False, True])
@pytest.mark.parametrize("off", [-0.3, -0.15, 0.15, 0.3])
def test_an_open_door_is_never_called_shut_by_a_robot_that_is_beside_where_it_believes(off, lidar):
    judged = pass_by(DoorWatch(FLOOR.doors.values()), shut=False, off=off, lidar=lidar)
    assert (DOOR.name, False) not in judged


def test_who_walks_between_robot_and_door_tells_nothing_of_it():
    assert pass_by(DoorWatch(FLOOR.doors.values()), shut=False, company=0.5) == []


def test_one_who_stands_before_a_door_has_not_passed_it():
    watch = DoorWatch(FLOOR.doors.values())
    for tick in range(400):
        assert watch.look(pose(0.0), senses(0.0, shut=True), 0.1 * tick) == []
    assert watch.look(pose(3.0), senses(3.0, shut=True), 41.0) == []


def test_what_was_begun_goes_on_after_a_restart_and_is_dropped_by_who_is_lost():
    watch, other = DoorWatch(FLOOR.doors.values()), DoorWatch(FLOOR.doors.values())
    for tick, along in enumerate(np.arange(-0.7, 0.8, 0.1)):
        watch.look(pose(along), senses(along, shut=True), 0.2 * tick)
    thaw(other, json.loads(json.dumps(freeze(watch))))
    gone = pose(1.5), senses(1.5, shut=True), 4.0
    assert other.look(*gone) == [(DOOR.name, False)]
    watch.forget()
    assert watch.look(*gone) == []


def test_driving_along_the_corridor_past_doors_tells_how_they_stand():
    """So it does on eleven of twelve such drives, with seeds 0 to 11."""
    loop = Loop(seed=3)
    loop.drive("r-5303")
    memory = loop.navigator.memory
    loop.world.set_door("r-5307", is_open=False)
    memory.shut("d-5309", loop.sensors.time)
    drive = loop.drive("r-5313")
    assert drive.failure is None
    outlook = memory.outlook(loop.sensors.time)
    assert outlook.doors == frozenset()
    assert [door for door, _ in outlook.doubtful_doors] == ["d-5307"]
    assert "d-5309" not in memory.believed(loop.sensors.time).doors
    assert [step.door.name for step in loop.start("r-5307").steps if step.door][-1] == "d-5307"


def test_what_was_glimpsed_costs_a_detour_and_never_the_goal():
    planner, memory = Planner(FLOOR), Memory()
    place = FLOOR.places["r-5307"]
    free = planner.plan(FLOOR.places["r-5303"], place)
    memory.glimpse("d-5307", 100.0)
    wary = planner.plan(FLOOR.places["r-5303"], place, memory.outlook(101.0))
    assert [step.to for step in wary] == [step.to for step in free]
    costs = sum(step.seconds for step in wary) - sum(step.seconds for step in free)
    assert costs == pytest.approx(60.0, abs=1.0)
    assert memory.believed(101.0).doors == frozenset()
    copy = Memory()
    copy.restore(json.loads(json.dumps(memory.snapshot())))
    assert copy.outlook(300.0) == memory.outlook(300.0) != Hindrances()
    memory.opened("d-5307")
    assert memory.outlook(101.0) == Hindrances()
    copy.forget_since(50.0)
    assert copy.outlook(101.0) == Hindrances()


def test_the_doors_around_are_kept_for_few_places():
    watch, silence = DoorWatch(FLOOR.doors.values()), np.full(24, np.inf)
    nothing = Percept(silence, 0, silence, 0)
    for metre in range(2 * MOST_CELLS):
        watch.look((float(metre), 0.0, 0.0), nothing, float(metre))
    assert watch._around.cache_info().currsize == MOST_CELLS
