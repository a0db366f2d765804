"""The robots' bodies among walls and doors: pymunk, with nothing in it that a snapshot loses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pymunk
from numpy.typing import NDArray

from xavier_sim.body._disc import Disc
from xavier_sim.floors import WALL_RADIUS, Geometry
from xavier_sim.profile import PHYSICS_STEP, BaseProfile

ROBOT, WALL, DISC = 1, 2, 3
OPEN = pymunk.ShapeFilter(categories=0, mask=0)
SHUT = pymunk.ShapeFilter()

FRICTION = 0.3


@dataclass
class BodyState:
    """Pose and velocities of the body: metres, radians, seconds."""

    x: float
    y: float
    theta: float
    vx: float = 0.0
    vy: float = 0.0
    turn_rate: float = 0.0

    def forward_speed(self) -> float:
        """Velocity along the heading, m/s."""
        return self.vx * math.cos(self.theta) + self.vy * math.sin(self.theta)


@dataclass(frozen=True)
class Contact:
    """A touch during one step: its direction from the robot's centre, radians in the map frame.

    ``depth`` is in metres, ``person`` the number of whoever was touched. A touch between two
    robots is a contact of each.
    """

    direction: float
    depth: float
    person: int | None = None


class Touch(NamedTuple):
    """What pymunk tells of a contact: unit normal, depth in metres, number of a disc or -1."""

    nx: float
    ny: float
    depth: float
    disc: int = -1


class RobotBody:
    """A disc with a heading, which `Physics` moves; ``contacts`` are those of the last step."""

    def __init__(self, space: pymunk.Space, base: BaseProfile, start: BodyState) -> None:
        self._space = space
        moment = pymunk.moment_for_circle(base.mass, 0.0, base.radius)
        self._body = pymunk.Body(base.mass, moment)
        self.shape = pymunk.Circle(self._body, base.radius)
        self.shape.friction, self.shape.elasticity = FRICTION, 0.0
        self.shape.collision_type = ROBOT
        space.add(self._body, self.shape)
        self.touches: list[Touch] = []
        self.contacts: list[Contact] = []
        self._pushed: tuple[float, float, float] | None = None
        self._state: BodyState | None = None
        self._heading = start.theta
        self.state = start

    @property
    def state(self) -> BodyState:
        """Pose and velocities now; read once between two steps, as reading is slow.

        The velocities are those of the last push, unless the robot has run into something.
        """
        if self._state is None:
            body = self._body
            x, y = body.position
            if self._pushed is not None and not self.touches:
                self._state = BodyState(x, y, self._heading, *self._pushed)
            else:
                vx, vy = body.velocity
                self._state = BodyState(x, y, self._heading, vx, vy, body.angular_velocity)
        return self._state

    @state.setter
    def state(self, state: BodyState) -> None:
        body = self._body
        body.position, body.velocity = (state.x, state.y), (state.vx, state.vy)
        body.angle, body.angular_velocity = state.theta, state.turn_rate
        self._space.reindex_shapes_for_body(body)
        self._pushed, self._state, self._heading = None, None, state.theta

    def moved(self) -> None:
        """Forget the state that was read: a step has passed."""
        self._state, self._heading = None, self._body.angle

    @property
    def velocities(self) -> tuple[float, float]:
        """Speed along the heading in m/s and turn rate in rad/s, as `state` has them.

        Quicker than that where the position is not needed: at each step of the physics.
        """
        if self._state is None and self._pushed is not None and not self.touches:
            (vx, vy, turn_rate), heading = self._pushed, self._heading
            return vx * math.cos(heading) + vy * math.sin(heading), turn_rate
        state = self.state
        return state.forward_speed(), state.turn_rate

    def push(self, speed: float, turn_rate: float) -> None:
        """Set the velocities for the next step, in which they last: m/s ahead, rad/s."""
        body, heading = self._body, self._heading
        # Pymunk, which adds its forces, none here, would make a negative zero positive.
        vx, vy = speed * math.cos(heading) + 0.0, speed * math.sin(heading) + 0.0
        pushed = (vx, vy, turn_rate + 0.0)
        # Pymunk keeps what nothing ran into: a robot that stands needs no push.
        if pushed != self._pushed or self.touches:
            body.velocity, body.angular_velocity = (vx, vy), turn_rate
        self._pushed, self._state = pushed, None

    def undo_overlap(self) -> None:
        """Move out of whatever was touched."""
        x, y = self._body.position
        for nx, ny, depth, _ in self.touches:
            x, y = x - nx * depth, y - ny * depth
        self._body.position = (x, y)
        self._state = None


class Physics:
    """Robots on a floor of static segments, and what they run into: walls, discs, each other.

    A disc does not give way to a robot; whoever moves discs does so between two ticks.

    Between two steps pymunk keeps neither cached contacts (the robots' shapes are put in anew
    after a touch) nor pushing-out velocities (``collision_bias`` 1; overlap is undone here). So
    poses and velocities are the whole state, and a restored world goes on bit for bit. Setting
    ``collision_persistence`` to 0 instead would switch the response to collisions off.
    """

    def __init__(self, geometry: Geometry) -> None:
        self._space = pymunk.Space()
        self._space.collision_persistence = 1
        self._space.collision_bias = 1.0
        self._space.collision_slop = 0.0
        self._robots: dict[pymunk.Shape, RobotBody] = {}
        self._touched: list[RobotBody] = []
        self._discs: dict[int, Disc] = {}
        self._posts: dict[int, pymunk.Body] = {}
        self._shapes: dict[int, pymunk.Circle] = {}
        self._add_walls(geometry.walls)
        self._doors = [self._segment(*row) for row in geometry.doors]
        for shape in self._doors:
            shape.filter = OPEN
        self._space.on_collision(ROBOT, WALL, pre_solve=self._met_wall)
        self._space.on_collision(ROBOT, ROBOT, pre_solve=self._met_robot)
        self._space.on_collision(ROBOT, DISC, pre_solve=self._met_disc)

    def add_robot(self, base: BaseProfile, start: BodyState) -> RobotBody:
        """Put a robot on the floor."""
        robot = RobotBody(self._space, base, start)
        self._robots[robot.shape] = robot
        return robot

    def set_door(self, index: int, *, is_open: bool) -> None:
        """Open or shut a door; the shape stays in the space, so that its order never changes."""
        self._doors[index].filter = OPEN if is_open else SHUT

    def surround(self, discs: Mapping[int, Disc]) -> None:
        """Put discs on the floor, by their numbers, in place of those that are there."""
        for number in self._discs:
            self._space.remove(self._shapes[number])
        self._discs = {}
        self.forget()
        for number, disc in discs.items():
            if number not in self._shapes:
                self._make_disc(number, disc.radius)
            self._shapes[number].unsafe_set_radius(disc.radius)
            self._posts[number].position = (disc.x, disc.y)
            self._space.add(self._shapes[number])
        self._discs = dict(discs)

    def step(self) -> None:
        """Move for `PHYSICS_STEP` seconds; what was touched stands in each robot's contacts."""
        for robot in self._touched:
            robot.touches, robot.contacts = [], []
        self._touched.clear()
        self._space.step(PHYSICS_STEP)
        for robot in self._robots.values():
            robot.moved()
        if self._touched:
            self._part()

    def _part(self) -> None:
        """Undo overlaps, and forget the contacts that pymunk keeps."""
        for robot in self._touched:
            robot.touches.sort()
            robot.undo_overlap()
            robot.contacts = [self._contact(touch) for touch in robot.touches]
        self.forget()

    def forget(self) -> None:
        """Put what moves in anew, always in one order: pymunk then remembers nothing."""
        shapes = [*self._robots, *(self._shapes[number] for number in self._discs)]
        for shape in shapes:
            self._space.remove(shape)
        for shape in shapes:
            self._space.add(shape)

    def _met_wall(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        del space, data
        one, other = arbiter.shapes
        nx, ny, depth = _touch(arbiter)
        if one.collision_type == ROBOT:
            self._touch(one, nx, ny, depth)
        else:
            self._touch(other, -nx, -ny, depth)

    def _met_robot(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        del space, data
        one, other = arbiter.shapes
        nx, ny, depth = _touch(arbiter)
        self._touch(one, nx, ny, depth / 2)
        self._touch(other, -nx, -ny, depth / 2)

    def _met_disc(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        del space, data
        one, other = arbiter.shapes
        nx, ny, depth = _touch(arbiter)
        if one.collision_type == ROBOT:
            self._touch(one, nx, ny, depth, self._number(other))
        else:
            self._touch(other, -nx, -ny, depth, self._number(one))

    def _touch(
        self, shape: pymunk.Shape, nx: float, ny: float, depth: float, disc: int = -1
    ) -> None:
        robot = self._robots[shape]
        if not robot.touches:
            self._touched.append(robot)
        robot.touches.append(Touch(nx, ny, depth, disc))

    def _contact(self, touch: Touch) -> Contact:
        is_person = touch.disc in self._discs and self._discs[touch.disc].person
        direction = math.atan2(touch.ny, touch.nx)
        return Contact(direction, touch.depth, touch.disc if is_person else None)

    def _number(self, shape: pymunk.Shape) -> int:
        return next(number for number in self._discs if self._shapes[number] is shape)

    def _make_disc(self, number: int, radius: float) -> None:
        body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        shape = pymunk.Circle(body, radius)
        shape.friction, shape.elasticity, shape.collision_type = FRICTION, 0.0, DISC
        self._space.add(body)
        self._posts[number], self._shapes[number] = body, shape

    def _add_walls(self, walls: NDArray[np.float64]) -> None:
        for row in walls:
            self._segment(*row)

    def _segment(self, x0: float, y0: float, x1: float, y1: float) -> pymunk.Segment:
        ends = (float(x0), float(y0)), (float(x1), float(y1))
        shape = pymunk.Segment(self._space.static_body, *ends, WALL_RADIUS)
        shape.friction, shape.elasticity, shape.collision_type = FRICTION, 0.0, WALL
        self._space.add(shape)
        return shape


def _touch(arbiter: pymunk.Arbiter) -> tuple[float, float, float]:
    """The normal of a touch, from the first shape to the second, and its depth in metres."""
    points = arbiter.contact_point_set
    depth = max((-point.distance for point in points.points), default=0.0)
    return points.normal.x, points.normal.y, max(depth, 0.0)
