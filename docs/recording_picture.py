"""A drive, recorded, and the picture that comes out of the recording."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from navigate.maps import Floor, load_plan
from navigate.navigator import Navigator
from navigate.reporting import belief_state
from xavier_sim.cli._recording import beginning_of
from xavier_sim.floors import load_floor
from xavier_sim.messages import DoorMoved, Drive
from xavier_sim.profile import PROFILES
from xavier_sim.recording import Belief, Tape
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

GOAL, SHUT = "r-5309", "r-5305"
MOST_TICKS = 3000

MOMENTS = (0.62, 0.93)
"""Shares of the drive at which readings are drawn, besides where the light striper sees most."""

MARGIN = 3.0
"""Metres round the drive that the picture shows."""

SCALE = 40
"""Pixels a metre."""

HEADER = 100
"""Pixels above the floor, for the legend."""

Pose = tuple[float, float, float]
Point = tuple[float, float]

LINES = (
    ("truth", "where the robot was"),
    ("reckoned", "where its wheels would have it"),
    ("shut", "a shut door"),
)
DOTS = (
    ("believed", "where the navigator believed it to be"),
    ("beam", "what the light striper saw"),
    ("cone", "what the sonars heard"),
)

STYLE = """
.walls { stroke: #40424a } .shut { stroke: #c0392b } .open { stroke: #7fbf8f }
.truth { stroke: #1f5fae } .reckoned { stroke: #d0762a; stroke-dasharray: 8 5 }
.cone { fill: #f0a030; fill-opacity: 0.3; stroke: none } .body { fill: #1f5fae; fill-opacity: 0.7 }
.beam { fill: #b02090 } .believed { fill: none; stroke: #208040; stroke-width: 2 }
text { font: 16px sans-serif; fill: #333 } line, polyline { fill: none; stroke-width: 3 }
"""


def record_drive(path: Path) -> None:
    """Let the navigator drive from the foyer to a room, and record it; the same each time."""
    world = World(load_floor(), 3, PROFILES["hard"])
    state = RobotState(world, SimClock(0.0), speed=None)
    navigator = Navigator(Floor(load_plan()), seed=3)
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        shut = world.set_door(SHUT, is_open=False)
        moved = DoorMoved(room=SHUT, open=shut.is_open, time=state.now, door=shut.name)
        tape.note(moved, state.now)
        navigator.step(state.sensors())
        drive = navigator.start(navigator.floor.place(GOAL), state.sensors())
        for tick in range(MOST_TICKS):
            tape.sense(state.sensors(), state.true_location())
            if tick % 10 == 0:
                told = belief_state(navigator, None).model_dump()
                tape.believe(Belief.model_validate({"state": told}))
            if drive.done:
                break
            wheels = navigator.wheels
            command = Drive(tick=tick, speed=wheels.speed, turn_rate=wheels.turn, busy=True)
            tape.note(command, state.now)
            world.step(wheels.speed, wheels.turn)
            navigator.step(state.sensors())
        tape.finish(dropped=0)


class Drawn:
    """What a recording shows, collected from the channels that Foxglove shows."""

    def __init__(self, path: Path) -> None:
        self.truth: list[Pose] = []
        self.reckoned: list[Pose] = []
        self.believed: list[Pose] = []
        self.moments: list[dict[str, Any]] = []
        self.beams: list[Any] = []
        self.walls: Any = None
        self.doors: Any = None
        self._cones: dict[str, Any] = {}
        self._start: Pose | None = None
        for topic, message in _shown(path):
            self._take(topic, message)

    @property
    def brightest(self) -> int:
        """The first tick at which the light striper sees most."""
        seen = [sum(map(math.isfinite, scan.ranges)) for scan in self.beams]
        return seen.index(max(seen))

    def _take(self, topic: str, message: Any) -> None:
        match topic:
            case "/floor":
                self.walls = message.entities[0].lines[0]
            case "/doors":
                self.doors = message.entities[0].lines
            case "/truth":
                self.truth.append(_pose(message.pose.position, message.pose.orientation))
            case "/position":
                self.believed.append(_pose(message.pose.position, message.pose.orientation))
            case "/tf":
                start, odom = (
                    _pose(one.translation, one.rotation) for one in message.transforms[:2]
                )
                self._start = self._start or start
                self.reckoned.append(_composed(self._start, odom))
            case "/striper":
                self.beams.append(message)
            case "/sonar":
                for entity in message.entities:
                    self._cones[entity.id] = entity.triangles[0]
                for deletion in message.deletions:
                    self._cones.pop(deletion.id, None)
                self.moments.append(dict(self._cones))


def draw_recording() -> str:
    """The picture, as SVG: north is to the right."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mcap"
        record_drive(path)
        drawn = Drawn(path)
    xs, ys = [x for x, _, _ in drawn.truth], [y for _, y, _ in drawn.truth]
    low = (min(xs) - MARGIN, min(ys) - MARGIN)
    size = (max(xs) - low[0] + MARGIN, max(ys) - low[1] + MARGIN)
    picture = _Picture(low, size)
    picture.segments(drawn.walls, "walls")
    for lines, style in zip(drawn.doors, ("shut", "open"), strict=True):
        picture.segments(lines, style)
    for moment in (*(round(share * (len(drawn.truth) - 1)) for share in MOMENTS), drawn.brightest):
        _draw_moment(picture, drawn, moment)
    picture.path(drawn.reckoned, "reckoned")
    picture.path(drawn.truth, "truth")
    for x, y, _ in drawn.believed[::3]:
        picture.circle((x, y), 0.12, "believed")
    picture.legend()
    return picture.text()


def _draw_moment(picture: _Picture, drawn: Drawn, number: int) -> None:
    here = drawn.truth[number]
    for cone in drawn.moments[min(number, len(drawn.moments) - 1)].values():
        picture.area([_composed(here, (p.x, p.y, 0.0))[:2] for p in cone.points], "cone")
    scan = drawn.beams[number]
    step = (scan.end_angle - scan.start_angle) / (len(scan.ranges) - 1)
    for beam, reach in enumerate(scan.ranges):
        if math.isfinite(reach):
            angle = scan.start_angle + beam * step
            at = (scan.pose.position.x + reach * math.cos(angle), reach * math.sin(angle), 0.0)
            picture.circle(_composed(here, at)[:2], 0.05, "beam")
    picture.circle(here[:2], 0.305, "body")


class _Picture:
    """An SVG of a part of the floor, metres turned into pixels."""

    def __init__(self, low: Point, size: Point) -> None:
        self._low, width, height = low, size[1] * SCALE, size[0] * SCALE + HEADER
        self._root = Element(
            "svg", xmlns="http://www.w3.org/2000/svg", viewBox=f"0 0 {width:.0f} {height:.0f}"
        )
        SubElement(self._root, "title").text = "A drive, drawn from its recording"
        SubElement(self._root, "style").text = STYLE
        SubElement(self._root, "rect", width="100%", height="100%", fill="white")

    def segments(self, lines: Any, style: str) -> None:
        ends = [(point.x, point.y) for point in lines.points]
        for begin, end in zip(ends[::2], ends[1::2], strict=True):
            self.path([begin, end], style)

    def path(self, points: list[Any], style: str) -> None:
        self._shape("polyline", points, style)

    def area(self, points: list[Any], style: str) -> None:
        self._shape("polygon", points, style)

    def circle(self, at: Point, radius: float, style: str) -> None:
        x, y = self._pixel(at)
        where = {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": f"{radius * SCALE:.1f}", "class": style}
        SubElement(self._root, "circle", where)

    def legend(self) -> None:
        SubElement(self._root, "rect", width="100%", height=f"{HEADER}", fill="white")
        for row, (style, text) in enumerate(LINES):
            y = 24 + 24 * row
            ends = {"x1": "12", "x2": "60", "y1": f"{y}", "y2": f"{y}"}
            SubElement(self._root, "line", {**ends, "class": style})
            SubElement(self._root, "text", x="70", y=f"{y + 5}").text = text
        for row, (style, text) in enumerate(DOTS):
            y = 24 + 24 * row
            dot = {"cx": "440", "cy": f"{y}", "r": "5", "class": style}
            SubElement(self._root, "circle", dot)
            SubElement(self._root, "text", x="455", y=f"{y + 5}").text = text

    def text(self) -> str:
        return tostring(self._root, encoding="unicode") + "\n"

    def _shape(self, kind: str, points: list[Any], style: str) -> None:
        pixels = " ".join("{:.1f},{:.1f}".format(*self._pixel(point)) for point in points)
        SubElement(self._root, kind, {"points": pixels, "class": style})

    def _pixel(self, point: Any) -> Point:
        x, y = point[0] - self._low[0], point[1] - self._low[1]
        return y * SCALE, x * SCALE + HEADER


def _shown(path: Path) -> Iterator[tuple[str, Any]]:
    decoder = DecoderFactory()
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            decode = decoder.decoder_for(channel.message_encoding, schema)
            if decode is not None and not channel.topic.startswith("wire/"):
                yield channel.topic, decode(message.data)


def _pose(at: Any, rotation: Any) -> Pose:
    return at.x, at.y, 2.0 * math.atan2(rotation.z, rotation.w)


def _composed(outer: Pose, inner: Pose) -> Pose:
    cos, sin = math.cos(outer[2]), math.sin(outer[2])
    x, y, theta = inner
    return outer[0] + cos * x - sin * y, outer[1] + sin * x + cos * y, outer[2] + theta
