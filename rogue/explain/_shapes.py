"""What a drawing is made of: the page with its style, shapes, lines of text, and the key."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from rogue.explain._layout import Place, Size
from rogue.explain._scene import CHARACTER
from rogue.explain._words import cells, clean
from rogue.prodigy import Standing

MARGIN = 28.0
"""Pixels round the drawing."""

CLASSES = {
    Standing.PENDING: "pending",
    Standing.RUNNING: "running",
    Standing.DONE: "done",
    Standing.EXECUTED: "executed",
    Standing.FAILED: "failed",
    Standing.DROPPED: "dropped",
}
"""Names of the standings in the style sheet."""

_STYLE = """
svg { background: #ffffff; }
text { font: 12px ui-monospace, Menlo, Consolas, "DejaVu Sans Mono", monospace; fill: #1b1f24; }
.number { font-size: 11px; fill: #57606a; }
.note { font-size: 11px; font-style: italic; fill: #b42318; }
.sign { fill: none; stroke: #1a6b2d; stroke-width: 2; stroke-linecap: round; }
.failed .sign { stroke: #b42318; }
.running .sign { fill: #9a6700; stroke: #9a6700; }
.reference .shape { fill: none; stroke-dasharray: 2 4; }
.name { font-weight: bold; }
.shape { fill: #ffffff; stroke: #57606a; stroke-width: 1.2; }
.link { fill: none; stroke: #8c959f; stroke-width: 1.2; }
.shared { stroke-dasharray: 2 4; }
.done .shape { fill: #eef4fb; stroke: #3a6ea5; }
.executed .shape { fill: #dcebdd; stroke: #1a6b2d; stroke-width: 2.6; }
.running .shape { fill: #fff1cc; stroke: #9a6700; stroke-width: 3.2; }
.failed .shape { fill: #fbeae9; stroke: #b42318; stroke-dasharray: 7 3; }
.dropped .shape { fill: #f6f8fa; stroke: #8c959f; stroke-dasharray: 2 3; }
.dropped text { fill: #6e7781; }
.badge { fill: #1a6b2d; }
.order { font-size: 11px; font-weight: bold; fill: #ffffff; text-anchor: middle; }
@media (prefers-color-scheme: dark) {
svg { background: #0d1117; }
text { fill: #e6edf3; }
.number { fill: #9198a1; }
.shape { fill: #151b23; stroke: #9198a1; }
.link { stroke: #656c76; }
.done .shape { fill: #10233a; stroke: #79b0ee; }
.executed .shape { fill: #12331b; stroke: #56d364; }
.running .shape { fill: #3a2d05; stroke: #e3b341; }
.failed .shape { fill: #3b1512; stroke: #ff7b72; }
.note { fill: #ff7b72; }
.sign { stroke: #56d364; }
.failed .sign { stroke: #ff7b72; }
.running .sign { fill: #e3b341; stroke: #e3b341; }
.dropped .shape { fill: #0d1117; stroke: #656c76; }
.dropped text { fill: #9198a1; }
.badge { fill: #2ea043; }
}
"""


def document(width: float, height: float, title: str) -> ET.Element:
    """Return an empty page of so many pixels, headed by its title."""
    root = ET.Element(
        "svg",
        {
            "xmlns": "http://www.w3.org/2000/svg",
            "width": f"{width:.0f}",
            "height": f"{height:.0f}",
            "viewBox": f"0 0 {width:.0f} {height:.0f}",
            "role": "img",
        },
    )
    ET.SubElement(root, "title").text = clean(title)
    ET.SubElement(root, "style").text = _STYLE
    heading = {"class": "name", "x": f"{MARGIN:g}", "y": f"{MARGIN:g}"}
    ET.SubElement(root, "text", heading).text = clean(title)
    return root


def oval(size: Size) -> ET.Element:
    """Return the shape of a goal, its middle at the origin."""
    radii = {"rx": f"{size.width / 2:g}", "ry": f"{size.height / 2:g}"}
    return ET.Element("ellipse", {"class": "shape", **radii})


def box(size: Size) -> ET.Element:
    """Return the shape of an operator, its middle at the origin."""
    corner = {"x": f"{-size.width / 2:g}", "y": f"{-size.height / 2:g}"}
    extent = {"width": f"{size.width:g}", "height": f"{size.height:g}"}
    return ET.Element("rect", {"class": "shape", **corner, **extent})


def curve(start: Place, end: Place) -> str:
    """Return the path of a link from the foot of one shape to the head of another."""
    bend = max(abs(end.y - start.y) / 2, 12.0)
    return (
        f"M{start.x:.1f} {start.y:.1f} C{start.x:.1f} {start.y + bend:.1f} "
        f"{end.x:.1f} {end.y - bend:.1f} {end.x:.1f} {end.y:.1f}"
    )


_SIGNS = {
    Standing.RUNNING: "M-3 -4 L4 0 L-3 4 Z",
    Standing.DONE: "M-4 0 L-1 3 L4 -4",
    Standing.EXECUTED: "M-4 0 L-1 3 L4 -4",
    Standing.FAILED: "M-3 -3 L3 3 M3 -3 L-3 3",
}


def sign(standing: Standing, x: float, y: float) -> list[ET.Element]:
    """Return the sign of a standing, drawn since fonts may lack it; none for what is open."""
    if standing not in _SIGNS:
        return []
    place = f"translate({x:g} {y:g})"
    return [ET.Element("path", {"class": "sign", "d": _SIGNS[standing], "transform": place})]


def badge(words: str, x: float, y: float) -> list[ET.Element]:
    """Return a disc with a word in it, its middle at ``x`` and ``y``."""
    disc = ET.Element("circle", {"class": "badge", "r": "9", "cx": f"{x:g}", "cy": f"{y:g}"})
    label = ET.Element("text", {"class": "order", "x": f"{x:g}", "y": f"{y + 4:g}"})
    label.text = words
    return [disc, label]


@dataclass(frozen=True, slots=True)
class Part:
    """Something that stands beneath the tree, with its extent in pixels."""

    element: ET.Element
    width: float
    height: float


def caption(lines: Sequence[tuple[str, str]]) -> Part:
    """Return lines of text, each given as its class and its words."""
    group = ET.Element("g", {"class": "caption"})
    for row, (kind, words) in enumerate(lines):
        attributes = {"class": kind, "y": f"{row * 18 + 12:g}", "xml:space": "preserve"}
        ET.SubElement(group, "text", attributes).text = clean(words)
    width = max((cells(words) for _, words in lines), default=0) * CHARACTER
    return Part(group, width, len(lines) * 18.0)


def key() -> Part:
    """Return what the shapes and their lines mean."""
    group = ET.Element("g", {"class": "key"})
    rows = [("pending", "goal", oval), *((one.value, "operator", box) for one in Standing)]
    for row, (words, kind, shape) in enumerate(rows):
        line = ET.SubElement(group, "g", {"transform": f"translate(24 {row * 22 + 8:g})"})
        line.set("class", CLASSES[Standing(words)])
        line.append(shape(Size(40.0, 14.0)))
        ET.SubElement(line, "text", {"x": "32", "y": "4"}).text = f"{kind}, {words}"
    return Part(group, 190.0, len(rows) * 22.0)
