"""The goal tree as a drawing: goals in ovals, operators in boxes, the plan beneath.

After Figures 5 and 9 of Haigh & Veloso (1996).
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as ET

from rogue.explain._scene import LINE, Figure, Scene, compose
from rogue.explain._shapes import (
    CLASSES,
    MARGIN,
    badge,
    box,
    caption,
    curve,
    document,
    key,
    oval,
    sign,
)
from rogue.explain._words import clean, shortened
from rogue.prodigy import GoalTree, TreeNode

_HEADER = 26.0
_MOST_OTHERS = 8


def draw_svg(tree: GoalTree, *, title: str = "Search tree") -> str:
    """Return ``tree`` as an SVG document, as large as the tree is.

    Hovering over a goal or an operator tells which rule chose it over what, and why it failed.
    """
    scene = compose(tree)
    drawn = ET.Element("g", transform=f"translate({MARGIN:g} {MARGIN + _HEADER:g})")
    for link in scene.links:
        kind = "link shared" if link.is_shared else "link"
        ET.SubElement(drawn, "path", {"class": kind, "d": curve(link.start, link.end)})
    applications = _applications(tree)
    for figure in scene.figures:
        drawn.append(_drawn(figure, applications.get(figure.node.number)))
    return _paged(drawn, scene, tree, title)


def _paged(drawn: ET.Element, scene: Scene, tree: GoalTree, title: str) -> str:
    plan, legend = caption(_captions(tree, scene.left_out)), key()
    top = scene.extent.height + 2 * MARGIN + _HEADER
    aside = MARGIN + max(plan.width + MARGIN, 420.0)
    plan.element.set("transform", f"translate({MARGIN:g} {top:g})")
    legend.element.set("transform", f"translate({aside:g} {top:g})")
    width = max(scene.extent.width + 2 * MARGIN, aside + legend.width + MARGIN)
    height = top + max(plan.height, legend.height) + MARGIN
    root = document(width, height, title)
    root.extend((drawn, plan.element, legend.element))
    return ET.tostring(root, encoding="unicode") + "\n"


@dataclass(frozen=True, slots=True)
class _Applied:
    """How an operator was applied: its node, and its place in the plan, from 1; 0 for none."""

    number: int
    place: int


def _applications(tree: GoalTree) -> dict[int, _Applied]:
    """How each operator was applied: as it stands in the plan, or else the last time."""
    places = {step.number: place for place, step in enumerate(tree.steps, 1)}
    found: dict[int, _Applied] = {}
    for node in tree.nodes:
        if node.applied:
            planned = [number for number in node.applied if number in places]
            number = (planned or node.applied)[-1]
            found[node.number] = _Applied(number, places.get(number, 0))
    return found


def _drawn(figure: Figure, applied: _Applied | None) -> ET.Element:
    node, size = figure.node, figure.size
    group = ET.Element(
        "g",
        {
            "class": "reference" if figure.is_reference else CLASSES[node.standing],
            "transform": f"translate({figure.place.x:.1f} {figure.place.y:.1f})",
        },
    )
    ET.SubElement(group, "title").text = clean(_tooltip(node))
    group.append(oval(size) if node.is_goal else box(size))
    first = -(len(figure.lines) - 1) * LINE / 2 + 4
    for row, line in enumerate(figure.lines):
        kind = "words" if row or node.is_goal else "name"
        attributes = {"class": kind, "text-anchor": "middle", "y": f"{first + row * LINE:g}"}
        ET.SubElement(group, "text", attributes).text = line
    if not figure.is_reference:
        group.set("id", f"n{node.number}")
        _mark(group, figure, applied)
    return group


def _mark(group: ET.Element, figure: Figure, applied: _Applied | None) -> None:
    """Add the numbers, the sign of the standing, the place in the plan, and why it failed."""
    node, size = figure.node, figure.size
    numbers = f"n{node.number} → n{applied.number}" if applied else f"n{node.number}"
    x = size.width / 2 - 7 * len(numbers) if node.is_goal else 18.0
    y = -size.height / 2 + (1 if node.is_goal else -5)
    ET.SubElement(group, "text", {"class": "number", "x": f"{x:g}", "y": f"{y:g}"}).text = numbers
    group.extend(sign(node.standing, x - 8, y - 4))
    if applied and applied.place:
        group.extend(badge(str(applied.place), -size.width / 2, -size.height / 2))
    if node.note:
        under = {"class": "note", "y": f"{size.height / 2 + 13:g}", "text-anchor": "middle"}
        note = shortened(clean(node.note), int(size.width / 6.6) + 2)
        ET.SubElement(group, "text", under).text = note


def _captions(tree: GoalTree, left_out: int) -> list[tuple[str, str]]:
    lines = [("name", "Solution:" if tree.status == "solved" else "Plan:")]
    for place, step in enumerate(tree.steps, 1):
        lines.append(("words", f"{place:3d}  {clean(step.text)}  {step.standing.value}"))
    if not tree.steps:
        lines.append(("words", "no step yet" if not tree.status else "no step"))
    if tree.status and tree.status != "solved":
        lines.append(("words", f"The search ended: {tree.status}."))
    if left_out:
        lines.append(("words", f"{left_out} more goals and operators are not drawn."))
    return lines


def _tooltip(node: TreeNode) -> str:
    lines = [f"n{node.number} {node.name} {node.args}".rstrip(), f"It is {node.standing.value}."]
    if node.reason:
        lines.append(f"Chosen by: {node.reason}.")
    if node.over:
        others = "; ".join(node.over[:_MOST_OTHERS])
        more = len(node.over) - _MOST_OTHERS
        lines.append(f"Instead of: {others}{f' and {more} more' if more > 0 else ''}.")
    if node.note:
        lines.append(f"It failed: {node.note}.")
    return "\n".join(lines)
