"""What Foxglove draws in its 3D panel: the floor, its doors, the robot, and sonar cones.

Metres, in the frames of REP-105. Foxglove has no message for a sonar's range, so a cone is a
triangle fan from the sonar to the arc on which the echo lies somewhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CylinderPrimitive_pb2 import CylinderPrimitive
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from xavier_sim.messages import SONAR_CONE, SONAR_COUNT, SONAR_RING_RADIUS, Standing

ARC_POINTS = 5
"""Points on the arc of a cone."""

WALL_WIDTH, DOOR_WIDTH = 0.04, 0.08
"""Thickness of drawn lines, metres."""

BODY_RADIUS, BODY_HEIGHT = 0.305, 1.2
"""Xavier's, metres."""

PERSON_HEIGHT, THING_HEIGHT = 1.7, 1.0
"""Of those who stand about, metres."""

WALL_COLOR = Color(r=0.25, g=0.25, b=0.28, a=1.0)
SHUT_COLOR = Color(r=0.75, g=0.2, b=0.15, a=1.0)
OPEN_COLOR = Color(r=0.3, g=0.65, b=0.35, a=0.5)
BODY_COLOR = Color(r=0.1, g=0.35, b=0.7, a=0.6)
PERSON_COLOR = Color(r=0.55, g=0.3, b=0.6, a=0.8)
THING_COLOR = Color(r=0.5, g=0.45, b=0.35, a=0.8)
CONE_COLOR = Color(r=0.95, g=0.6, b=0.1, a=0.35)

FAN = [index for tip in range(1, ARC_POINTS) for index in (0, tip, tip + 1)]
"""Corners of a cone's triangles: point 0 is the sonar."""

_BEARINGS = 2.0 * math.pi / SONAR_COUNT * np.arange(SONAR_COUNT)
_ARCS = _BEARINGS[:, None] + np.linspace(-SONAR_CONE / 2, SONAR_CONE / 2, ARC_POINTS)
_MOUNTS = SONAR_RING_RADIUS * np.stack([np.cos(_BEARINGS), np.sin(_BEARINGS)], axis=1)
_DIRECTIONS = np.stack([np.cos(_ARCS), np.sin(_ARCS)], axis=2)

Segment = Sequence[float]
"""x0, y0, x1, y1 in metres."""


def timestamp(nanoseconds: int) -> Timestamp:
    """A time as Foxglove has it."""
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    return Timestamp(seconds=seconds, nanos=rest)


def turn(theta: float) -> Quaternion:
    """A heading as a rotation about z."""
    return Quaternion(z=math.sin(theta / 2), w=math.cos(theta / 2))


def pose(x: float, y: float, theta: float) -> Pose:
    """A pose on the floor."""
    return Pose(position=Vector3(x=x, y=y), orientation=turn(theta))


def draw_walls(walls: Iterable[Segment], time: int) -> SceneUpdate:
    """All walls as one entity."""
    lines = _lines(walls, WALL_WIDTH, WALL_COLOR)
    return SceneUpdate(entities=[_entity("walls", "map", time, lines=[lines])])


def draw_doors(doors: Iterable[tuple[Segment, bool]], time: int) -> SceneUpdate:
    """All doors, open or shut, as one entity."""
    known = list(doors)
    shut = _lines([line for line, is_open in known if not is_open], DOOR_WIDTH, SHUT_COLOR)
    ajar = _lines([line for line, is_open in known if is_open], DOOR_WIDTH, OPEN_COLOR)
    return SceneUpdate(entities=[_entity("doors", "map", time, lines=[shut, ajar])])


def draw_body(frame: str, time: int) -> SceneUpdate:
    """The robot's body, which goes along with its frame."""
    body = _cylinder(0.0, 0.0, BODY_RADIUS, BODY_HEIGHT, BODY_COLOR)
    return SceneUpdate(entities=[_entity("robot", frame, time, cylinders=[body])])


def draw_crowd(standing: Iterable[tuple[int, Standing]], frame: str, time: int) -> SceneUpdate:
    """People, and things on the floor, each by its number and an entity of its own."""
    update = SceneUpdate()
    for number, one in standing:
        height = PERSON_HEIGHT if one.person else THING_HEIGHT
        color = PERSON_COLOR if one.person else THING_COLOR
        body = _cylinder(one.x, one.y, one.radius, height, color)
        update.entities.append(_entity(f"standing-{number}", frame, time, cylinders=[body]))
    return update


def draw_cones(
    sonar: NDArray[np.float32], fresh: Iterable[int], frame: str, time: int
) -> SceneUpdate:
    """The cones of the sonars that have just fired; one without an echo has none.

    Args:
        sonar: readings in metres from the ring, shape (24,).
        fresh: numbers of the sonars that fired.
        frame: of the robot.
        time: nanoseconds.
    """
    update = SceneUpdate()
    for number in fresh:
        reading, name = float(sonar[number]), f"sonar-{number:02}"
        if math.isfinite(reading):
            fan = _cone(number, reading)
            update.entities.append(_entity(name, frame, time, triangles=[fan]))
        else:
            gone = SceneEntityDeletion(
                timestamp=timestamp(time), type=SceneEntityDeletion.MATCHING_ID, id=name
            )
            update.deletions.append(gone)
    return update


def _cone(number: int, reading: float) -> TriangleListPrimitive:
    x, y = _MOUNTS[number]
    tips = _MOUNTS[number] + reading * _DIRECTIONS[number]
    points = [Point3(x=x, y=y), *(Point3(x=tip[0], y=tip[1]) for tip in tips.tolist())]
    return TriangleListPrimitive(
        pose=pose(0.0, 0.0, 0.0), points=points, color=CONE_COLOR, indices=FAN
    )


def _cylinder(x: float, y: float, radius: float, height: float, color: Color) -> CylinderPrimitive:
    return CylinderPrimitive(
        pose=Pose(position=Vector3(x=x, y=y, z=height / 2), orientation=turn(0.0)),
        size=Vector3(x=2 * radius, y=2 * radius, z=height),
        bottom_scale=1.0,
        top_scale=1.0,
        color=color,
    )


def _lines(segments: Iterable[Segment], width: float, color: Color) -> LinePrimitive:
    ends = [Point3(x=x, y=y) for x0, y0, x1, y1 in segments for x, y in ((x0, y0), (x1, y1))]
    return LinePrimitive(
        type=LinePrimitive.LINE_LIST,
        pose=pose(0.0, 0.0, 0.0),
        thickness=width,
        points=ends,
        color=color,
    )


def _entity(
    name: str,
    frame: str,
    time: int,
    *,
    lines: Iterable[LinePrimitive] = (),
    triangles: Iterable[TriangleListPrimitive] = (),
    cylinders: Iterable[CylinderPrimitive] = (),
) -> SceneEntity:
    return SceneEntity(
        timestamp=timestamp(time),
        frame_id=frame,
        id=name,
        frame_locked=True,
        lines=lines,
        triangles=triangles,
        cylinders=cylinders,
    )
