"""A corridor with people in it, a robot that knows where it is, and no physics but inertia."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import accumulate

import numpy as np

from navigate.body import BEARINGS, CONE_HALF, RING_RADIUS, ROBOT_RADIUS
from navigate.driving import Strangers, Surroundings, View, Wheels
from navigate.driving._courtesy import Courtesy
from navigate.driving._follow import follow, way_through
from navigate.driving._safety import guard
from navigate.driving._view import Trouble
from navigate.maps import Point
from xavier_sim.messages import Corner, Space, SpaceKind

PERSON = 0.25
TICK = 0.1

Walk = Callable[[float], tuple[float, float]]
"""Where somebody is at a time in seconds."""


def standing(x: float, y: float) -> Walk:
    return lambda _time: (x, y)


class Corridor:
    """Twenty metres along x, ``width`` wide, with people; `drive` takes the robot through."""

    def __init__(self, *people: Walk, width: float = 2.4) -> None:
        half = width / 2
        self.space = Space(
            name="corridor",
            kind=SpaceKind.CORRIDOR,
            low=Corner(x=-1.0, y=-half),
            high=Corner(x=21.0, y=half),
        )
        self.people = people
        self.time, self.pose, self.speed, self.turn = 0.0, (0.0, 0.0, 0.0), 0.0, 0.0
        self.touched: float | None = None
        self.nearest = math.inf
        self.speeds: list[float] = []
        self.strangers = Strangers()
        self.courtesy = Courtesy(self.strangers)
        self._heard = Surroundings()
        self._ranges = np.full(24, np.inf)

    def drive(self, *, metres: float = 15.0, seconds: float = 120.0) -> Trouble | None:
        """Drive along, up to a touch; what stopped the robot, None when it came through."""
        return self.drive_way((0.0, 0.0), (metres, 0.0), seconds=seconds)

    def driven(self) -> list[float]:
        """Metres driven up to each of `speeds`."""
        return list(accumulate(TICK * speed for speed in self.speeds))

    def drive_way(
        self,
        start: Point,
        goal: Point,
        *,
        tolerance: float = 0.12,
        settle: float = 0.0,
        seconds: float = 120.0,
    ) -> Trouble | None:
        """Drive a way, which need not begin where the robot is; as `drive`."""
        way = way_through(self.space, start, goal)
        course = follow(self._view(0), way, self.courtesy, tolerance=tolerance, settle=settle)
        view, wheels = None, Wheels(0.0, 0.0)
        for tick in range(round(seconds / TICK)):
            try:
                wheels = next(course) if view is None else course.send(view)
            except StopIteration:
                return None
            except Trouble as trouble:
                return trouble
            if view is not None:
                wheels = guard(wheels, view)
            self._move(wheels)
            view = self._view(tick)
            if self.touched is not None:
                return None
        raise AssertionError(f"still on the way at {self.pose}")

    def _move(self, wheels: Wheels) -> None:
        change = wheels.speed - self.speed
        self.speed += max(-1.4 * TICK, min(0.7 * TICK, change))
        self.turn += max(-0.3, min(0.3, wheels.turn - self.turn))
        x, y, theta = self.pose
        middle = theta + self.turn * TICK / 2
        step = self.speed * TICK
        self.pose = (
            x + step * math.cos(middle),
            y + step * math.sin(middle),
            theta + self.turn * TICK,
        )
        self.time += TICK
        self.speeds.append(self.speed)
        for walk in self.people:
            gap = math.dist(walk(self.time), self.pose[:2]) - PERSON - ROBOT_RADIUS
            self.nearest = min(self.nearest, gap)
            if gap < 0.0:
                self.touched = self.speed

    def _view(self, tick: int) -> View:
        fresh = sum(1 << number for number in range(tick % 4, 24, 4))
        for number in range(tick % 4, 24, 4):
            self._ranges[number] = self._sonar(number)
        self._heard.hear(self.pose, self._ranges, fresh, self.time)
        view = View(
            time=self.time,
            pose=self.pose,
            odom=self.pose,
            ranges=self._ranges.copy(),
            fresh=fresh,
            bump=0,
            echoes=self._heard.picture(self.pose, within=3.0).spots,
            speed=self.speed,
            turn=self.turn,
        )
        self.strangers.listen(view, [self.space])
        return view

    def _sonar(self, number: int) -> float:
        facing = self.pose[2] + BEARINGS[number]
        x = self.pose[0] + RING_RADIUS * math.cos(facing)
        y = self.pose[1] + RING_RADIUS * math.sin(facing)
        return min(self._ray(x, y, facing + part * CONE_HALF) for part in (-1, -0.5, 0, 0.5, 1))

    def _ray(self, x: float, y: float, angle: float) -> float:
        cos, sin = math.cos(angle), math.sin(angle)
        hits = [math.inf]
        for at, wall, along in (
            (x, self.space.low.x, cos),
            (x, self.space.high.x, cos),
            (y, self.space.low.y, sin),
            (y, self.space.high.y, sin),
        ):
            # Beyond 65 degrees of incidence the echo glances off.
            if (wall - at) * along > 0.0 and abs(along) > 0.42:
                hits.append((wall - at) / along)
        for walk in self.people:
            px, py = walk(self.time)
            ahead = (px - x) * cos + (py - y) * sin
            aside = (py - y) * cos - (px - x) * sin
            if ahead > 0.0 and abs(aside) < PERSON:
                hits.append(ahead - math.sqrt(PERSON**2 - aside**2))
        reading = min(hits)
        return max(0.2, reading) if reading < 6.5 else math.inf
