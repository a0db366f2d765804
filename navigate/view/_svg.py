"""Simulator and navigator side by side, as Figure 3 of Haigh & Veloso (1996) shows them.

Left how things really stand, where a simulator tells it; right what the navigator believes and
wants. Each has the whole floor, and beside it a closer look at the robot.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from xml.etree import ElementTree as ET

from navigate.maps import Floor
from navigate.messages import Outlook
from navigate.view._belief import draw_cells, draw_doubt, draw_way
from navigate.view._floor import draw_floor, draw_names, extent
from navigate.view._ink import Pane, Window
from navigate.view._robot import Pose, draw_body, draw_seen, draw_sonar
from navigate.view._style import STYLE
from navigate.view._words import of_navigator, of_world
from xavier_sim.messages import FloorPlan, WorldView

MARGIN, GAP, HEADER, FOOTER = 24.0, 14.0, 36.0, 44.0
"""Pixels."""

TALL, CLOSE = 600.0, 440.0
"""Pixels: the height of a picture, and the width of its closer look."""

WIDEST, NARROWEST = 440.0, 120.0
"""Pixels across that the whole floor takes at most and at least."""

SIGHT = 11.0
"""Metres across in the closer look."""


def draw_svg(outlook: Outlook, plan: FloorPlan, world: WorldView | None = None) -> str:
    """Return the drawing as an SVG document.

    Args:
        outlook: of the navigator.
        plan: the navigator's map.
        world: how things really stand, if anybody knows.
    """
    pictures: list[Picture] = [Real(world, outlook)] if world is not None else []
    pictures.append(Believed(outlook, Floor(plan)))
    width = sum(one.width + 2.0 * GAP for one in pictures) - 2.0 * GAP
    root = _document(width + 2.0 * MARGIN, 2.0 * MARGIN + HEADER + TALL + FOOTER)
    left = MARGIN
    for picture in pictures:
        picture.draw(root, left)
        left += picture.width + 2.0 * GAP
    return ET.tostring(root, encoding="unicode") + "\n"


class Picture(ABC):
    """The floor as a whole and as seen from near, with a title and lines of text."""

    title: str

    def __init__(self, floor: Floor, shut: set[str], outlook: Outlook) -> None:
        self.floor, self.shut, self.outlook = floor, shut, outlook
        self._whole = extent(floor)
        self._strip = min(WIDEST, max(NARROWEST, TALL * self._whole.width / self._whole.height))
        self.width = self._strip + GAP + CLOSE

    @property
    @abstractmethod
    def pose(self) -> Pose:
        """Where the robot is."""

    @property
    @abstractmethod
    def words(self) -> list[str]:
        """The lines beneath."""

    @abstractmethod
    def fill(self, pane: Pane) -> None:
        """Draw what lies on the floor."""

    def draw(self, root: ET.Element, left: float) -> None:
        """Put it on the page, its left edge at so many pixels."""
        top = MARGIN + HEADER
        _write(root, "title", left, MARGIN + 18.0, self.title)
        close = Window.about(self.pose[:2], SIGHT, SIGHT * TALL / CLOSE)
        far = Pane(root, self._whole, (left, top), (self._strip, TALL))
        draw_floor(far, self.floor, self.shut, wall="wall")
        self.fill(far)
        draw_body(far, self.pose, 0)
        far.box("lens", close)
        near = Pane(root, close, (left + self._strip + GAP, top), (CLOSE, TALL))
        self._draw_near(near)
        for number, words in enumerate(self.words):
            _write(root, "fact", left, top + TALL + 24.0 + 20.0 * number, words)

    def _draw_near(self, pane: Pane) -> None:
        draw_floor(pane, self.floor, self.shut, wall="near-wall")
        self.fill(pane)
        draw_sonar(pane, self.pose, self.outlook.sonar)
        draw_seen(pane, self.pose, self.outlook.seen)
        draw_body(pane, self.pose, self.outlook.bump)
        drive = self.outlook.drive
        draw_names(pane, self.floor, drive.room if drive else None)


class Real(Picture):
    """How things really stand, as the simulator tells it."""

    title = "Simulator"

    def __init__(self, world: WorldView, outlook: Outlook) -> None:
        floor, self._world = Floor(world.floor), world
        closed = {door.door or door.room for door in world.doors if not door.open}
        doors = floor.doors.values()
        shut = {door.name for door in doors if closed & {door.name, *door.spaces}}
        super().__init__(floor, shut, outlook)

    @property
    def pose(self) -> Pose:
        """Where the robot really is."""
        robot = self._world.robot
        return robot.x, robot.y, robot.theta

    @property
    def words(self) -> list[str]:
        """Where it is, since when, and how far off the belief is."""
        return of_world(self._world, self.outlook.belief.position)

    def fill(self, pane: Pane) -> None:
        """Draw the people, and the things that stand about."""
        for one in self._world.standing:
            pane.disc("person" if one.person else "thing", (one.x, one.y), one.radius)


class Believed(Picture):
    """What the navigator believes and wants."""

    title = "Navigator"

    def __init__(self, outlook: Outlook, floor: Floor) -> None:
        super().__init__(floor, set(outlook.shut), outlook)

    @property
    def pose(self) -> Pose:
        """Where the robot is believed to be."""
        position = self.outlook.belief.position
        return position.x, position.y, position.theta

    @property
    def words(self) -> list[str]:
        """What is believed, and how the drive goes."""
        return of_navigator(self.outlook)

    def fill(self, pane: Pane) -> None:
        """Draw belief, way and goal."""
        draw_cells(pane, self.outlook.belief)
        draw_way(pane, self.outlook)
        draw_doubt(pane, self.outlook.belief)


def _write(root: ET.Element, kind: str, x: float, y: float, words: str) -> None:
    where = {"class": kind, "x": f"{x:.1f}", "y": f"{y:.1f}"}
    ET.SubElement(root, "text", where).text = words


def _document(width: float, height: float) -> ET.Element:
    size = {"width": f"{width:.0f}", "height": f"{height:.0f}"}
    box = {"viewBox": f"0 0 {width:.0f} {height:.0f}", "role": "img"}
    root = ET.Element("svg", {"xmlns": "http://www.w3.org/2000/svg", **size, **box})
    ET.SubElement(root, "title").text = "Where the robot is, and where it believes to be"
    ET.SubElement(root, "style").text = STYLE
    return root
