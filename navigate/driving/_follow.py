"""Following a straight way through open floor: in a free lane, round what stands in it."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from navigate.body import ROBOT_RADIUS, wrap
from navigate.driving._courtesy import Courtesy
from navigate.driving._cvm import TOP_SPEED, Window, choose
from navigate.driving._lanes import Lane, pick_lane
from navigate.driving._strangers import STRANGERS_WITHIN, are_strange
from navigate.driving._turning import turn_rate
from navigate.driving._view import STOP, Manoeuvre, View, WayBlocked, Wheels
from navigate.maps import Floats, Point, inset
from xavier_sim.messages import Space

SLOW_SPEED, SPEED_PER_METRE = 0.12, 1.0
"""Metres per second at which it comes to stand, and what is added for each metre before."""

CARROT = 1.1
"""Metres ahead in the lane that the robot steers for, on free floor."""

TURN_FIRST = 0.7
"""Radians off beyond which the robot turns on the spot before it drives."""

PATIENCE, SETTLE_SECONDS = 15.0, 4.0
"""Seconds without coming nearer after which the way counts as blocked, and as driven where the
robot is near enough to its end."""

NEARER = 0.15
"""Metres that count as coming nearer."""

WALL_BERTH = ROBOT_RADIUS + 0.12
"""Metres from the walls of the map that the middle of a lane keeps."""

TIGHT_MARGIN = 0.03
BLOCKED_AHEAD = 0.25
"""Metres of free lane below which the robot waits."""

NEAR = 1.0
"""Metres within which an echo counts wherever it is: map and position may be wrong."""

LEAST_AHEAD, MOST_AHEAD = 0.8, 2.0
"""Metres ahead at which the hindrance of a blocked way may be."""

MOUTH_SPEED = 0.35
"""Metres per second past a door or corner that the robot cannot look into."""

MOUTH_NEAR = 0.55
"""Metres beside the robot below which it cannot stop for who steps out of one."""

MOUTH_AHEAD, MOUTH_BEHIND = 1.0, 0.3

CORNER_AHEAD, CORNER_BEHIND = 2.5, 0.5
"""Metres along the way within which somebody may come round a corner of open floor."""

SHORT = 0.3
"""Metres of a way whose direction says nothing of where the robot comes from."""

SLACK = 1e-6
"""Metres by which mouths are looked for farther off than they matter: more than any rounding."""


@dataclass(frozen=True)
class Way:
    """A straight way through a space, and how far to its right and left the floor reaches.

    ``mouths`` are the ends of its doors and openings, in their order: metres along the way and to
    its left; ``corners`` are those of its openings, metres along the way. ``beside`` are the open
    spaces from which it comes and to which it leads: what is in there is in the way as well.
    """

    space: Space
    start: Point
    goal: Point
    lowest: float = 0.0
    highest: float = 0.0
    mouths: tuple[Point, ...] = ()
    corners: tuple[float, ...] = ()
    beside: tuple[Space, ...] = ()

    @cached_property
    def length(self) -> float:
        """Metres."""
        return math.dist(self.start, self.goal)

    @cached_property
    def heading(self) -> float:
        """Radians in the map frame."""
        return math.atan2(self.goal[1] - self.start[1], self.goal[0] - self.start[0])

    @cached_property
    def direction(self) -> Point:
        """The unit vector in the map frame."""
        return math.cos(self.heading), math.sin(self.heading)

    def has_corner_near(self, along: float) -> bool:
        """Whether somebody may come round a corner to where the robot is, metres along the way."""
        return any(-CORNER_BEHIND < at - along < CORNER_AHEAD for at in self.corners)

    def around(self, at: Point) -> list[Space]:
        """The spaces of it that are near a point: in which echoes are in the way."""
        return [self.space, *(one for one in self.beside if inset(one, *at) > -STRANGERS_WITHIN)]

    def locate(self, at: Point) -> tuple[float, float]:
        """Metres along the way and to its left."""
        dx, dy = at[0] - self.start[0], at[1] - self.start[1]
        cos, sin = self.direction
        return dx * cos + dy * sin, dy * cos - dx * sin


def way_through(
    space: Space,
    start: Point,
    goal: Point,
    mouths: Iterable[tuple[Point, Point]] = (),
    *,
    openings: Iterable[tuple[Point, Point]] = (),
    beside: Iterable[Space] = (),
) -> Way:
    """The way between two points of a space, with lanes as far as the space is wide there.

    Args:
        space: what both points lie in.
        start: metres, like ``goal``.
        goal: where to.
        mouths: the two ends of each door and opening of the space.
        openings: those of the openings alone.
        beside: the open spaces before and behind it on the route.
    """
    others = tuple(one for one in dict.fromkeys(beside) if one != space)
    way = Way(space, start, goal, beside=others)
    corners = tuple(sorted({way.locate(end)[0] for ends in openings for end in ends}))
    way = replace(way, corners=corners)
    if way.length < 0.5:
        return way
    left = (-math.sin(way.heading), math.cos(way.heading))
    reach = [
        min(_reach(space, at, (side * left[0], side * left[1])) for at in (start, goal))
        for side in (-1.0, 1.0)
    ]
    return replace(
        way,
        lowest=-max(0.0, reach[0]),
        highest=max(0.0, reach[1]),
        mouths=tuple(sorted(way.locate(end) for mouth in mouths for end in mouth)),
    )


def follow(
    view: View,
    way: Way,
    courtesy: Courtesy,
    *,
    tolerance: float = 0.12,
    ends: bool = True,
    settle: float = 0.0,
) -> Manoeuvre[View]:
    """Drive along ``way`` to its goal, in the lane that is free.

    Args:
        view: the current tick.
        way: where to drive.
        courtesy: sees to those who are in the way.
        tolerance: metres from the goal, or beyond it, at which it counts as reached.
        ends: whether to slow down towards the goal, for a turn or a stop.
        settle: metres from the goal at which it will do where the robot comes no nearer: somebody
            may stand there.

    Raises:
        WayBlocked: the robot came no nearer for longer than `PATIENCE`.
    """
    nearest, since = math.inf, view.time
    lane: Lane | None = None
    while not _reached(view, way, tolerance):
        top = _top_speed(view, way, courtesy, ends=ends)
        echoes = _obstacles(view, way)
        lane = _lane(view, way, echoes, lane)
        view = yield _steer(view, way, echoes, lane, top)
        away = math.dist(view.at, way.goal)
        if away < nearest - NEARER:
            nearest, since = away, view.time
        elif away < settle and view.time - since > SETTLE_SECONDS:
            break
        elif view.time - since > PATIENCE:
            raise WayBlocked(_ahead(view, way, lane))
    return view


def _top_speed(view: View, way: Way, courtesy: Courtesy, *, ends: bool) -> float:
    """The speed that the goal, the doors beside the way and the people in it allow."""
    along, left = way.locate(view.at)
    distance = math.dist(view.at, way.goal)
    top = min(TOP_SPEED, SLOW_SPEED + SPEED_PER_METRE * distance) if ends else TOP_SPEED
    top = _past_mouths(way, along, left, top)
    wary = way.has_corner_near(along)
    return courtesy.speed(view, way.heading, top, wary=wary)


def _steer(view: View, way: Way, echoes: Floats, lane: Lane, top: float) -> Wheels:
    along, _ = way.locate(view.at)
    if top <= 0.0 or lane.free < min(BLOCKED_AHEAD, way.length - along):
        return STOP
    error = _bearing(view, way, along, lane)
    if abs(error) > TURN_FIRST:
        return Wheels(0.0, turn_rate(error))
    within = math.dist(view.at, way.goal) + 0.5
    squares = echoes * echoes
    near = echoes[squares[:, 0] + squares[:, 1] < within**2]
    choice = choose(near, error, Window.around(view.speed, view.turn, top))
    if choice.wheels.speed == 0.0:
        slow = Window.around(view.speed, view.turn, min(top, SLOW_SPEED))
        choice = choose(near, error, slow, margin=TIGHT_MARGIN)
    if choice.wheels.speed == 0.0 and abs(error) > 0.05:
        return Wheels(0.0, turn_rate(error))
    return choice.wheels


def _past_mouths(way: Way, along: float, left: float, top: float) -> float:
    """No more than ``top``, and less where somebody may step out right beside the robot."""
    first = bisect_left(way.mouths, (along - MOUTH_BEHIND - SLACK,))
    for at, aside in way.mouths[first:]:
        if at - along >= MOUTH_AHEAD:
            break
        if at - along > -MOUTH_BEHIND and abs(aside - left) - ROBOT_RADIUS < MOUTH_NEAR:
            return min(top, MOUTH_SPEED)
    return top


def _obstacles(view: View, way: Way) -> Floats:
    """The echoes that are near, or that are no walls: the lanes keep off those of the map.

    A cone that glances along a wall hears its near edge, half a metre into the corridor where
    it is plotted on the axis.
    """
    ahead, left = view.echoes[:, 0], view.echoes[:, 1]
    away = np.hypot(ahead, left)
    bearings, kept = np.arctan2(left, ahead), away < NEAR
    for space in way.around(view.at):
        kept |= are_strange(view.pose, space, away, bearings, view.spreads)
    return view.echoes[kept]


def _lane(view: View, way: Way, echoes: Floats, last: Lane | None) -> Lane:
    """The lane to drive in: the way itself near its goal, else the best."""
    along, left = way.locate(view.at)
    if way.length - along < CARROT / 2 or way.lowest == way.highest:
        return Lane(0.0, math.inf)
    turned = wrap(view.pose[2] - way.heading)
    cos, sin = math.cos(turned), math.sin(turned)
    spots: Floats = echoes @ np.array([[cos, sin], [-sin, cos]])
    spots[:, 1] += left
    return pick_lane(spots, left, way.lowest, way.highest, last.offset if last else None)


def _bearing(view: View, way: Way, along: float, lane: Lane) -> float:
    """Radians to turn left to look at the carrot: nearer ahead where the way is short."""
    reach = max(0.35, min(CARROT, 0.6 * lane.free, 0.6 * lane.straight))
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
    if way.length < SHORT:
        # The robot need not come along so short a way, nor pass its goal on it.
        return away < max(1.5 * tolerance, 0.2)
    along, _ = way.locate(view.at)
    return along > way.length and away < 3.0 * tolerance


def _ahead(view: View, way: Way, lane: Lane) -> Point:
    """Where the hindrance is: on from the robot in the direction of the goal."""
    metres = min(MOST_AHEAD, max(LEAST_AHEAD, lane.straight + ROBOT_RADIUS))
    heading = math.atan2(way.goal[1] - view.pose[1], way.goal[0] - view.pose[0])
    x, y = view.at
    return (x + metres * math.cos(heading), y + metres * math.sin(heading))


def _reach(space: Space, at: Point, direction: Point) -> float:
    """Metres from a point to the border of its space, less the berth."""
    limits = []
    for axis, low, high in ((0, space.low.x, space.high.x), (1, space.low.y, space.high.y)):
        if abs(direction[axis]) > 0.3:
            border = high if direction[axis] > 0.0 else low
            limits.append((border - at[axis]) / direction[axis])
    return min(limits) - WALL_BERTH
