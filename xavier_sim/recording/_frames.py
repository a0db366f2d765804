"""The frames of REP-105: where ``odom`` lies in ``map``, and the robot in both.

``map`` to ``odom`` is what the navigator believes; until it has said so, ``odom`` lies so that the
robot is where it began. The truth, which the robot does not know, has a frame of its own.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from xavier_sim.recording._scene import timestamp, turn

MAP, ODOM, BASE = "map", "odom", "base_link"
TRUTH = "base_link_truth"

MEMORY = 64
"""Ticks for which odometry is remembered: beliefs come a little late."""


@dataclass(frozen=True, slots=True)
class Pose2D:
    """Metres and radians in some frame."""

    x: float
    y: float
    theta: float

    def then(self, inner: Pose2D) -> Pose2D:
        """The pose in the outer frame of what lies at ``inner`` in this one."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        x = self.x + inner.x * cos - inner.y * sin
        y = self.y + inner.x * sin + inner.y * cos
        return Pose2D(x, y, self.theta + inner.theta)

    def inverse(self) -> Pose2D:
        """The outer frame seen from here."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return Pose2D(-self.x * cos - self.y * sin, self.x * sin - self.y * cos, -self.theta)


class Frames:
    """Keeps the transforms from tick to tick."""

    def __init__(self) -> None:
        self.map_to_odom: Pose2D | None = None
        self._odometry: deque[tuple[float, Pose2D]] = deque(maxlen=MEMORY)

    def move(self, odom: Pose2D, time: float, truth: Pose2D) -> None:
        """The odometry of a tick at a time in seconds, and where the robot really is in the map."""
        self._odometry.append((time, odom))
        if self.map_to_odom is None:
            self.map_to_odom = truth.then(odom.inverse())

    def believe(self, believed: Pose2D, time: float) -> None:
        """The navigator believes that the robot was at a pose in the map at a time."""
        past = [odom for when, odom in self._odometry if when <= time + 1e-6]
        if past:
            self.map_to_odom = believed.then(past[-1].inverse())

    def transforms(self, truth: Pose2D, nanoseconds: int) -> FrameTransforms:
        """All of them now, after a `move`."""
        _, odom = self._odometry[-1]
        assert self.map_to_odom is not None
        pairs = ((MAP, ODOM, self.map_to_odom), (ODOM, BASE, odom), (MAP, TRUTH, truth))
        when = timestamp(nanoseconds)
        return FrameTransforms(
            transforms=[
                FrameTransform(
                    timestamp=when,
                    parent_frame_id=parent,
                    child_frame_id=child,
                    translation=Vector3(x=at.x, y=at.y),
                    rotation=turn(at.theta),
                )
                for parent, child, at in pairs
            ]
        )
