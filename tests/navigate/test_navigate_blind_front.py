"""A robot whose front sonar is dead and that has no light looks at doors with its neighbours."""

from __future__ import annotations

import math

import numpy as np
import pytest
from navigate_readings import reading

from navigate.body import BEARINGS, RING_RADIUS, Perception
from navigate.driving import DoorLog, Surroundings, View, Wheels, must_stop
from navigate.driving._doorpass import pass_door
from navigate.driving._safety import BLIND_SPEED, guard
from navigate.driving._view import DoorShut
from navigate.maps import Floor, load_plan
from xavier_sim.messages import SONAR_COUNT

DOOR = Floor(load_plan()).doors["d-5303"]
HALF, BEFORE, ROOM = DOOR.width / 2, 1.2, 4.0
ALL = (1 << SONAR_COUNT) - 1
CONE = np.radians(np.linspace(-11.25, 11.25, 31))


def ring(turned, *, shut):
    """What sonars hear before a door in an endless wall, whose front one tells what both beside do.

    The robot stands on its axis, ``turned`` radians to the left of it.
    """
    heard = np.full(SONAR_COUNT, np.inf)
    for sonar, bearing in enumerate(BEARINGS):
        axis = turned + bearing
        away = BEFORE - RING_RADIUS * math.cos(axis)
        looks = axis + CONE
        facing = np.cos(looks) > 0.2
        crossing = RING_RADIUS * math.sin(axis) + away * np.tan(looks)
        through = (np.abs(crossing) < HALF) & (not shut)
        reach = np.where(through, away + ROOM, away) / np.cos(looks).clip(0.2)
        heard[sonar] = reach[facing].min(initial=np.inf)
    heard[0] = max(heard[1], heard[-1])
    return heard


class Before:
    """A robot before a door that passes it, up to where it sets out to creep through."""

    def __init__(self, *, shut: bool) -> None:
        self.shut, self.time, self.turned = shut, 0.0, 0.0
        self.turns: list[float] = []

    def run(self) -> None:
        course = pass_door(self._view(), DOOR, 1.0, DoorLog())
        wheels = next(course)
        while wheels.speed <= 0.0:
            self.time += 0.1
            self.turned += 0.1 * wheels.turn
            self.turns.append(self.turned)
            wheels = course.send(self._view())

    def _view(self) -> View:
        (nx, ny), (x, y) = DOOR.normal, DOOR.centre
        pose = (x - BEFORE * nx, y - BEFORE * ny, math.atan2(ny, nx) + self.turned)
        return View(
            time=self.time,
            pose=pose,
            odom=pose,
            ranges=ring(self.turned, shut=self.shut),
            fresh=ALL & ~1,
            bump=0,
            echoes=np.zeros((0, 2)),
            renewed=1,
            blind=1,
        )


def test_an_open_door_that_its_jambs_hide_is_found_open_by_turning_a_little():
    assert ring(0.0, shut=False)[0] < BEFORE
    robot = Before(shut=False)
    robot.run()
    assert robot.time < 10.0
    assert math.radians(12.0) < max(map(abs, robot.turns)) < math.radians(20.0)
    assert abs(robot.turned) < 0.05


def test_a_shut_door_is_shut_all_the_same():
    robot = Before(shut=True)
    with pytest.raises(DoorShut):
        robot.run()
    assert max(map(abs, robot.turns)) > math.radians(12.0)


def test_only_neighbours_stand_in_for_a_dead_front_and_the_robot_drives_slowly():
    perception = Perception()
    perception.sonars.unsound[0] = True
    readings = np.full(SONAR_COUNT, 3.0, dtype=np.float32)
    sensors = reading(sonar=readings)
    percept = perception.take_in(sensors, (0.0, 0.0, 0.0))
    assert percept.blind == 1
    echoes = Surroundings().picture((0.0, 0.0, 0.0), within=3.0).spots
    view = View(0.0, (0, 0, 0), (0, 0, 0), percept.ring, 0, 0, echoes, blind=percept.blind)
    assert guard(Wheels(0.6, 0.1), view) == Wheels(BLIND_SPEED, 0.1)
    assert guard(Wheels(-0.6, 0.1), view) == Wheels(-0.6, 0.1)


def test_what_both_neighbours_of_a_silent_front_touch_stops_the_wheels():
    readings = np.full(SONAR_COUNT, 3.0, dtype=np.float32)
    readings[0] = np.inf
    readings[1] = 0.2
    assert not must_stop(Wheels(0.3, 0.0), reading(sonar=readings, sonar_fresh=2))
    readings[-1] = 0.2
    assert must_stop(Wheels(0.3, 0.0), reading(sonar=readings, sonar_fresh=2))
    assert not must_stop(Wheels(0.3, 0.0), reading(sonar=readings, sonar_fresh=1))
