"""The robot's body among walls and doors: pymunk, with nothing in it that a snapshot loses."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

from xavier_sim.floors import WALL_RADIUS, Geometry
from xavier_sim.profile import PHYSICS_STEP, BaseProfile

ROBOT, WALL = 1, 2
ROBOT_CATEGORY = 2
OPEN = pymunk.ShapeFilter(categories=0, mask=0)
SHUT = pymunk.ShapeFilter()


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
    """A touch during one step: its direction from the robot's centre, radians in the map frame."""

    direction: float
    depth: float


class Physics:
    """A disc with a heading on a floor of static segments.

    Between two steps pymunk keeps neither cached contacts (the robot's shape is put in anew
    after a touch) nor pushing-out velocities (``collision_bias`` 1; overlap is undone here). So
    pose and velocities are the whole state, and a restored world goes on bit for bit. Setting
    ``collision_persistence`` to 0 instead would switch the response to collisions off.
    """

    def __init__(self, geometry: Geometry, base: BaseProfile, start: BodyState) -> None:
        self._space = pymunk.Space()
        self._space.collision_persistence = 1
        self._space.collision_bias = 1.0
        self._space.collision_slop = 0.0
        self._touches: list[tuple[float, float, float]] = []
        self._add_walls(geometry.walls)
        self._doors = [self._segment(*row) for row in geometry.doors]
        self._body, self._shape = self._add_robot(base)
        self._space.on_collision(ROBOT, WALL, pre_solve=self._touched)
        self.state = start

    @property
    def state(self) -> BodyState:
        """Pose and velocities now."""
        body = self._body
        (x, y), (vx, vy) = body.position, body.velocity
        return BodyState(x, y, body.angle, vx, vy, body.angular_velocity)

    @state.setter
    def state(self, state: BodyState) -> None:
        body = self._body
        body.position, body.velocity = (state.x, state.y), (state.vx, state.vy)
        body.angle, body.angular_velocity = state.theta, state.turn_rate
        self._space.reindex_shapes_for_body(body)

    def set_door(self, index: int, *, is_open: bool) -> None:
        """Open or shut a door; the shape stays in the space, so that its order never changes."""
        self._doors[index].filter = OPEN if is_open else SHUT

    def step(self, speed: float, turn_rate: float) -> list[Contact]:
        """Move for `PHYSICS_STEP` seconds with these velocities, and tell what was touched."""
        body = self._body
        heading = body.angle
        body.velocity = (speed * math.cos(heading), speed * math.sin(heading))
        body.angular_velocity = turn_rate
        self._touches.clear()
        self._space.step(PHYSICS_STEP)
        return self._undo_overlap() if self._touches else []

    def _undo_overlap(self) -> list[Contact]:
        x, y = self._body.position
        for nx, ny, depth in self._touches:
            x, y = x - nx * depth, y - ny * depth
        self._body.position = (x, y)
        self._space.remove(self._shape)
        self._space.add(self._shape)
        return [Contact(math.atan2(ny, nx), depth) for nx, ny, depth in self._touches]

    def _touched(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        del space, data
        points = arbiter.contact_point_set
        sign = 1.0 if arbiter.shapes[0].collision_type == ROBOT else -1.0
        depth = max((-point.distance for point in points.points), default=0.0)
        self._touches.append((sign * points.normal.x, sign * points.normal.y, max(depth, 0.0)))

    def _add_walls(self, walls: NDArray[np.float64]) -> None:
        for row in walls:
            self._segment(*row)

    def _segment(self, x0: float, y0: float, x1: float, y1: float) -> pymunk.Segment:
        ends = (float(x0), float(y0)), (float(x1), float(y1))
        shape = pymunk.Segment(self._space.static_body, *ends, WALL_RADIUS)
        shape.friction, shape.elasticity, shape.collision_type = 0.3, 0.0, WALL
        self._space.add(shape)
        return shape

    def _add_robot(self, base: BaseProfile) -> tuple[pymunk.Body, pymunk.Circle]:
        body = pymunk.Body(base.mass, pymunk.moment_for_circle(base.mass, 0.0, base.radius))
        shape = pymunk.Circle(body, base.radius)
        shape.friction, shape.elasticity, shape.collision_type = 0.3, 0.0, ROBOT
        shape.filter = pymunk.ShapeFilter(categories=ROBOT_CATEGORY)
        self._space.add(body, shape)
        return body, shape
