"""Following a straight way through open floor: in a free lane, round what stands in it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navigate.body import ROBOT_RADIUS, wrap
from navigate.driving._cvm import TOP_SPEED, Window, choose
from navigate.driving._lanes import Lane, pick_lane
from navigate.driving._turning import turn_rate
from navigate.driving._view import STOP, Manoeuvre, View, WayBlocked, Wheels
from navigate.maps import Floats, Point
from xavier_sim.messages import Space

SLOW_SPEED = 0.12
CARROT = 1.1
"""Metres ahead in the lane that the robot steers for, on free floor."""

TURN_FIRST = 0.7
"""Radians off beyond which the robot turns on the spot before it drives."""

PATIENCE = 15.0
"""Seconds without coming nearer after which the way counts as blocked."""

NEARER = 0.15
"""Metres that count as coming nearer."""

WALL_BERTH = ROBOT_RADIUS + 0.12
"""Metres from the walls of the map that the middle of a lane keeps."""

TIGHT_MARGIN = 0.03
BLOCKED_AHEAD = 0.25
"""Metres of free lane below which the robot waits."""


@dataclass(frozen=True, slots=True)
class Way:
    """A straight way on the map, and how far to its right and left the floor reaches."""

    start: Point
    goal: Point
    lowest: float = 0.0
    highest: float = 0.0

    @property
    def length(self) -> float:
        """Metres."""
        return math.dist(self.start, self.goal)

    @property
    def heading(self) -> float:
        """Radians in the map frame."""
        return math.atan2(self.goal[1] - self.start[1], self.goal[0] - self.start[0])

    def locate(self, at: Point) -> tuple[float, float]:
        """Metres along the way and to its left."""
        dx, dy = at[0] - self.start[0], at[1] - self.start[1]
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return dx * cos + dy * sin, dy * cos - dx * sin


def way_through(space: Space, start: Point, goal: Point) -> Way:
    """The way between two points of a space, with lanes as far as the space is wide there."""
    if math.dist(start, goal) < 0.5:
        return Way(start, goal)
    way = Way(start, goal)
    left = (-math.sin(way.heading), math.cos(way.heading))
    reach = [
        min(_reach(space, at, (side * left[0], side * left[1])) for at in (start, goal))
        for side in (-1.0, 1.0)
    ]
    return Way(start, goal, -max(0.0, reach[0]), max(0.0, reach[1]))


def follow(view: View, way: Way, *, tolerance: float = 0.12, ends: bool = True) -> Manoeuvre[View]:
    """Drive along ``way`` to its goal, in the lane that is free.

    Args:
        view: the current tick.
        way: where to drive.
        tolerance: metres from the goal, or beyond it, at which it counts as reached.
        ends: whether to slow down towards the goal, for a turn or a stop.

    Raises:
        WayBlocked: the robot came no nearer for longer than `PATIENCE`.
    """
    nearest, since = math.inf, view.time
    while not _reached(view, way, tolerance):
        view = yield _steer(view, way, ends=ends)
        away = math.dist(view.at, way.goal)
        if away < nearest - NEARER:
            nearest, since = away, view.time
        elif view.time - since > PATIENCE:
            raise WayBlocked(_ahead(view, way, 0.8))
    return view


def _steer(view: View, way: Way, *, ends: bool) -> Wheels:
    along, left = way.locate(view.at)
    distance = math.dist(view.at, way.goal)
    lane = _lane(view, way, along, left)
    if lane.free < BLOCKED_AHEAD and lane.free < way.length - along:
        return STOP
    error = _bearing(view, way, along, lane)
    if abs(error) > TURN_FIRST:
        return Wheels(0.0, turn_rate(error))
    top = min(TOP_SPEED, SLOW_SPEED + 0.7 * distance) if ends else TOP_SPEED
    near = view.echoes[(view.echoes**2).sum(axis=1) < (distance + 0.5) ** 2]
    choice = choose(near, error, Window.around(view.speed, view.turn, top))
    if choice.wheels.speed == 0.0:
        slow = Window.around(view.speed, view.turn, SLOW_SPEED)
        choice = choose(near, error, slow, margin=TIGHT_MARGIN)
    if choice.wheels.speed == 0.0 and abs(error) > 0.05:
        return Wheels(0.0, turn_rate(error))
    return choice.wheels


def _lane(view: View, way: Way, along: float, left: float) -> Lane:
    """The lane to drive in: the way itself near its goal, else the best."""
    if way.length - along < CARROT / 2 or way.lowest == way.highest:
        return Lane(0.0, math.inf)
    turned = wrap(view.pose[2] - way.heading)
    cos, sin = math.cos(turned), math.sin(turned)
    spots: Floats = view.echoes @ np.array([[cos, sin], [-sin, cos]])
    spots[:, 1] += left
    return pick_lane(spots, left, way.lowest, way.highest)


def _bearing(view: View, way: Way, along: float, lane: Lane) -> float:
    """Radians to turn left to look at the carrot: nearer ahead where the lane is short."""
    reach = max(0.35, min(CARROT, lane.free * 0.6))
    if along + reach >= way.length:
        heading = math.atan2(way.goal[1] - view.pose[1], way.goal[0] - view.pose[0])
        return wrap(heading - view.pose[2])
    _, left = way.locate(view.at)
    ahead = reach if along >= 0.0 else reach - along
    return wrap(way.heading + math.atan2(lane.offset - left, ahead) - view.pose[2])


def _reached(view: View, way: Way, tolerance: float) -> bool:
    """Whether the robot is at the goal, or has passed it closely enough."""
    away = math.dist(view.at, way.goal)
    if away < tolerance:
        return True
    if way.length < 0.05:
        return away < max(tolerance, 0.2)
    along, _ = way.locate(view.at)
    return along > way.length and away < 3.0 * tolerance


def _ahead(view: View, way: Way, metres: float) -> Point:
    """A point on from the robot in the direction of the goal, which is where the hindrance is."""
    x, y, _ = view.pose
    heading = math.atan2(way.goal[1] - y, way.goal[0] - x)
    return (x + metres * math.cos(heading), y + metres * math.sin(heading))


def _reach(space: Space, at: Point, direction: Point) -> float:
    """Metres from a point to the border of its space, less the berth."""
    limits = []
    for axis, low, high in ((0, space.low.x, space.high.x), (1, space.low.y, space.high.y)):
        if abs(direction[axis]) > 0.3:
            border = high if direction[axis] > 0.0 else low
            limits.append((border - at[axis]) / direction[axis])
    return min(limits) - WALL_BERTH
