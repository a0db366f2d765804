"""What Foxglove is shown of each thing that happens: messages of its own schemas, by topic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Odometry_pb2 import Odometry
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.message import Message as Proto
from pydantic import BaseModel

from xavier_sim.floors import build_geometry
from xavier_sim.messages import (
    BUMP_PANELS,
    LIDAR_VIEW,
    SONAR_COUNT,
    STRIPER_AHEAD,
    STRIPER_VIEW,
    Battery,
    DoorMoved,
    Fault,
    PlateReading,
    Sensors,
    Standing,
    TrueLocation,
)
from xavier_sim.recording._format import Beginning, nanoseconds
from xavier_sim.recording._frames import BASE, MAP, ODOM, TRUTH, Frames, Pose2D
from xavier_sim.recording._heard import BeliefState
from xavier_sim.recording._scene import (
    draw_body,
    draw_cones,
    draw_crowd,
    draw_doors,
    draw_walls,
    pose,
    timestamp,
)

View = tuple[str, Proto]
"""A topic and what to show there."""


class Views:
    """Makes the views of one recording."""

    def __init__(self, beginning: Beginning) -> None:
        self.frames = Frames()
        self._geometry = build_geometry(beginning.floor)
        self._open = {door.door or door.room: door.open for door in beginning.doors}
        self._bump = 0
        self._standing: Sequence[Standing] = ()

    def begin(self, time: int) -> Iterator[View]:
        """What stands still, at a time in nanoseconds."""
        yield "/floor", draw_walls(self._geometry.walls.tolist(), time)
        yield "/doors", self._doors(time)
        yield "/robot", draw_body(TRUTH, time)

    def sense(
        self, sensors: Sensors, truth: TrueLocation, standing: Sequence[Standing]
    ) -> Iterator[View]:
        """A tick."""
        time = nanoseconds(sensors.time)
        yield from self._poses(sensors, truth, time)
        yield from self._crowd(standing, time)
        yield from _scans(sensors, time)
        fresh = [number for number in range(SONAR_COUNT) if sensors.sonar_fresh >> number & 1]
        if fresh:
            yield "/sonar", draw_cones(sensors.sonar, fresh, BASE, time)
        if sensors.bump and not self._bump:
            panels = [str(n) for n in range(BUMP_PANELS) if sensors.bump >> n & 1]
            yield "/log", _log(Log.WARNING, f"bump at panel {', '.join(panels)}", time)
        self._bump = sensors.bump

    def _poses(self, sensors: Sensors, truth: TrueLocation, time: int) -> Iterator[View]:
        really = Pose2D(truth.x, truth.y, truth.theta)
        self.frames.move(Pose2D(*sensors.odom.tolist()), sensors.time, really)
        yield "/tf", self.frames.transforms(really, time)
        yield "/odometry", _odometry(sensors, time)
        stands = pose(really.x, really.y, really.theta)
        yield "/truth", PoseInFrame(timestamp=timestamp(time), frame_id=MAP, pose=stands)

    def _crowd(self, standing: Sequence[Standing], time: int) -> Iterator[View]:
        """Those who have moved since the last tick."""
        before, self._standing = self._standing, standing
        known = dict(enumerate(before))
        moved = [(n, one) for n, one in enumerate(standing) if known.get(n) != one]
        if moved:
            yield "/crowd", draw_crowd(moved, MAP, time)

    def note(self, message: BaseModel, time: int) -> Iterator[View]:
        """Something else that was said or done, at a time in nanoseconds."""
        match message:
            case DoorMoved(room=room, open=is_open, door=door):
                self._open[door or room] = is_open
                yield "/doors", self._doors(time)
                stands = "opened" if is_open else "closed"
                yield "/log", _log(Log.INFO, f"the door of {room} was {stands}", time)
            case Fault(fault=fault):
                yield "/log", _log(Log.WARNING, f"fault {fault.model_dump_json()}", time)
            case PlateReading(text=text, confidence=confidence):
                says = f"a plate that says {text}, {confidence:.2f}" if text else "no plate"
                yield "/log", _log(Log.INFO, f"the camera sees {says}", time)
            case Battery(state=state):
                charging = ", charging" if state.charging else ""
                yield "/log", _log(Log.DEBUG, f"battery {state.charge:.0%}{charging}", time)
            case _:
                return

    def believe(self, state: BeliefState, time: int) -> Iterator[View]:
        """What the navigator believes: the pose, and the cells of the belief."""
        at, when = state.position, timestamp(time)
        self.frames.believe(Pose2D(at.x, at.y, at.theta), at.time)
        yield (
            "/position",
            PoseInFrame(timestamp=when, frame_id=MAP, pose=pose(at.x, at.y, at.theta)),
        )
        cells = [pose(cell.x, cell.y, cell.theta) for cell in state.cells]
        yield "/belief/cells", PosesInFrame(timestamp=when, frame_id=MAP, poses=cells)

    def _doors(self, time: int) -> Proto:
        geometry, known = self._geometry, self._open
        names = zip(geometry.door_names, geometry.door_rooms, strict=True)
        stands = [known.get(name, known.get(room, True)) for name, room in names]
        return draw_doors(zip(geometry.doors.tolist(), stands, strict=True), time)


def _odometry(sensors: Sensors, time: int) -> Odometry:
    x, y, theta = sensors.odom.tolist()
    return Odometry(
        timestamp=timestamp(time),
        frame_id=ODOM,
        body_frame_id=BASE,
        pose=pose(x, y, theta),
        linear_velocity=Vector3(x=sensors.speed),
        angular_velocity=Vector3(z=sensors.turn_rate),
    )


def _scans(sensors: Sensors, time: int) -> Iterator[View]:
    """What the laser beams see, of the sensors that this robot has."""
    looks = (
        ("/striper", sensors.striper, pose(STRIPER_AHEAD, 0.0, 0.0), STRIPER_VIEW),
        ("/lidar", sensors.lidar, pose(0.0, 0.0, 0.0), LIDAR_VIEW),
    )
    for topic, ranges, mount, view in looks:
        if not ranges.size:
            continue
        yield (
            topic,
            LaserScan(
                timestamp=timestamp(time),
                frame_id=BASE,
                pose=mount,
                start_angle=-view / 2,
                end_angle=view / 2,
                ranges=ranges.tolist(),
            ),
        )


def _log(level: Log.Level.ValueType, text: str, time: int) -> Log:
    return Log(timestamp=timestamp(time), level=level, message=text, name="xavier")
