"""Drawing in metres on a page in pixels: y grows upwards on the floor and downwards on the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self
from xml.etree import ElementTree as ET

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Window:
    """A rectangle of the floor, in metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    @classmethod
    def holding(cls, points: Iterable[Point], *, margin: float = 0.0) -> Self:
        """The smallest that holds all points, and so many metres round them."""
        xs, ys = zip(*points, strict=True)
        return cls(min(xs) - margin, min(ys) - margin, max(xs) + margin, max(ys) + margin)

    @classmethod
    def about(cls, centre: Point, width: float, height: float) -> Self:
        """One of a given size round a point."""
        (x, y), half, tall = centre, width / 2, height / 2
        return cls(x - half, y - tall, x + half, y + tall)

    @property
    def width(self) -> float:
        """Metres from west to east."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """Metres from south to north."""
        return self.y1 - self.y0

    def touches(self, x0: float, y0: float, x1: float, y1: float) -> bool:
        """Whether a rectangle, or the box round a line, is to be seen in it."""
        across = max(x0, x1) >= self.x0 and min(x0, x1) <= self.x1
        return across and max(y0, y1) >= self.y0 and min(y0, y1) <= self.y1


class Pane:
    """A pane of the page that shows a window of the floor.

    Args:
        page: to which it is added, with a frame round it.
        window: the part of the floor to show, in metres.
        at: its upper left corner in pixels.
        size: its width and height in pixels; the window is shown whole, in the middle.
    """

    def __init__(self, page: ET.Element, window: Window, at: Point, size: Point) -> None:
        (left, top), (width, height) = at, size
        self.scale = min(width / window.width, height / window.height)
        self._middle = ((window.x0 + window.x1) / 2, (window.y0 + window.y1) / 2)
        self._centre = (width / 2, height / 2)
        self.window = Window.about(self._middle, width / self.scale, height / self.scale)
        extent = {"width": f"{width:.1f}", "height": f"{height:.1f}"}
        where = {"x": f"{left:.1f}", "y": f"{top:.1f}"}
        self._element = ET.SubElement(page, "svg", {**where, **extent})
        ET.SubElement(self._element, "rect", {"class": "ground", **extent})
        ET.SubElement(page, "rect", {"class": "frame", **where, **extent})

    def disc(self, kind: str, at: Point, radius: float) -> None:
        """A circle, its radius in metres."""
        x, y = self._on_page(at)
        where = {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": f"{radius * self.scale:.1f}"}
        ET.SubElement(self._element, "circle", {"class": kind, **where})

    def box(self, kind: str, window: Window, *, opacity: float | None = None) -> None:
        """A rectangle, by its corners in metres."""
        if not self.window.touches(window.x0, window.y0, window.x1, window.y1):
            return
        x, y = self._on_page((window.x0, window.y1))
        where = {"class": kind, "x": f"{x:.1f}", "y": f"{y:.1f}"}
        width, height = window.width * self.scale, window.height * self.scale
        size = {"width": f"{width:.1f}", "height": f"{height:.1f}"}
        drawn = ET.SubElement(self._element, "rect", {**where, **size})
        _fade(drawn, opacity)

    def line(self, kind: str, points: Sequence[Point], *, opacity: float | None = None) -> None:
        """A line through points."""
        drawn = ET.SubElement(self._element, "path", {"class": kind, "d": self._through(points)})
        _fade(drawn, opacity)

    def segments(self, kind: str, ends: Iterable[Sequence[float]]) -> None:
        """Many straight lines of x0, y0, x1, y1 as one shape."""
        seen = [end for end in ends if self.window.touches(*end)]
        if seen:
            drawn = "".join(self._through([(x0, y0), (x1, y1)]) for x0, y0, x1, y1 in seen)
            ET.SubElement(self._element, "path", {"class": kind, "d": drawn})

    def arc(self, kind: str, at: Point, look: float, half: float, radius: float) -> None:
        """A part of a circle: ``half`` radians to either side of ``look``."""
        drawn = "M" + self._arc(at, look, half, radius)
        ET.SubElement(self._element, "path", {"class": kind, "d": drawn})

    def wedge(self, kind: str, at: Point, look: float, half: float, radius: float) -> None:
        """A slice of a disc."""
        drawn = f"M{self._pixels(at)}L{self._arc(at, look, half, radius)}Z"
        ET.SubElement(self._element, "path", {"class": kind, "d": drawn})

    def text(self, kind: str, at: Point, words: str) -> None:
        """A line of text, its middle at a point in metres."""
        x, y = self._on_page(at)
        where = {"class": kind, "x": f"{x:.1f}", "y": f"{y + 4:.1f}"}
        ET.SubElement(self._element, "text", where).text = words

    def _arc(self, at: Point, look: float, half: float, radius: float) -> str:
        begin, end = polar(at, look - half, radius), polar(at, look + half, radius)
        size = f"{radius * self.scale:.1f}"
        return f"{self._pixels(begin)}A{size} {size} 0 0 0 {self._pixels(end)}"

    def _through(self, points: Sequence[Point]) -> str:
        return "M" + "L".join(self._pixels(point) for point in points)

    def _pixels(self, point: Point) -> str:
        x, y = self._on_page(point)
        return f"{x:.1f} {y:.1f}"

    def _on_page(self, point: Point) -> Point:
        (x, y), (east, north), (right, down) = point, self._middle, self._centre
        return right + (x - east) * self.scale, down - (y - north) * self.scale


def polar(at: Point, angle: float, distance: float) -> Point:
    """The point so far from another, in a direction."""
    return at[0] + distance * math.cos(angle), at[1] + distance * math.sin(angle)


def _fade(drawn: ET.Element, opacity: float | None) -> None:
    if opacity is not None:
        drawn.set("opacity", f"{opacity:.2f}")
