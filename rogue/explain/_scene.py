"""What is drawn of a goal tree, and where: figures, links between them, the extent."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from rogue.explain._layout import Layout, Place, Size, lay_out
from rogue.explain._words import cells, clean, shortened, wrapped
from rogue.prodigy import GoalTree, TreeNode

MOST_GONE = 60
"""Failed and given up goals and operators that are drawn: those that were tried first."""

MOST_LIVE = 2000
"""Other goals and operators that are drawn, the newest."""

CHARACTER, LINE = 7.25, 15.0
"""Pixels of a column and of a line of text."""

_COLUMNS = 23
_ROW_WIDTH, _LEVEL_GAP = 1700.0, 34.0
_FARTHEST = 650.0

_Pair = tuple[int, int]
"""A goal and an operator that shares it with the one that the goal hangs from."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A shape: the goal or operator, the lines in it, and where it is.

    A reference stands for a goal that is drawn elsewhere.
    """

    node: TreeNode
    lines: tuple[str, ...]
    size: Size
    place: Place
    is_reference: bool = False


@dataclass(frozen=True, slots=True)
class Link:
    """A line from a figure down to one that it needs, or that was chosen for it."""

    start: Place
    end: Place
    is_shared: bool = False


@dataclass(frozen=True, slots=True)
class Scene:
    """Everything of a drawing but its plan; ``left_out`` counts what is not drawn."""

    figures: tuple[Figure, ...]
    links: tuple[Link, ...]
    extent: Size
    left_out: int


def compose(tree: GoalTree) -> Scene:
    """Return what is drawn of ``tree``.

    A goal that several operators need hangs from the first. From the others a line leads to it
    where it is near, and a reference stands below them where it is not.
    """
    tree = tree.pruned(most_live=MOST_LIVE, most_gone=MOST_GONE)
    shown = {node.number: node for node in tree.nodes}
    near = _shared(shown.values(), shown)
    far: list[_Pair] = []
    layout = _arranged(shown, far)
    far = [pair for pair in near if not _is_near(layout, *pair)]
    if far:
        layout = _arranged(shown, far)
    near = [pair for pair in near if pair not in far]
    figures = [
        _figure(node, layout.places[number], is_reference=False) for number, node in shown.items()
    ]
    for at, (goal, _) in enumerate(far, 1):
        figures.append(_figure(shown[goal], layout.places[-at], is_reference=True))
    links = [_link(shown, layout, above, below) for above, below in _hanging(shown)]
    links += [_link(shown, layout, sharer, goal, is_shared=True) for goal, sharer in near]
    links += [_link_to_reference(shown, layout, far, at) for at in range(1, len(far) + 1)]
    return Scene(tuple(figures), tuple(links), layout.extent, tree.left_out)


def _hanging(shown: Mapping[int, TreeNode]) -> list[tuple[int, int]]:
    """Each figure with the one above it, that one first."""
    return [(node.above, number) for number, node in shown.items() if node.above in shown]


def _shared(nodes: Iterable[TreeNode], shown: Mapping[int, TreeNode]) -> list[_Pair]:
    return [(n.number, sharer) for n in nodes for sharer in n.shared_by if sharer in shown]


def _arranged(shown: Mapping[int, TreeNode], references: Sequence[_Pair]) -> Layout:
    children: dict[int, list[int]] = {}
    hanging = _hanging(shown)
    for above, below in hanging:
        children.setdefault(above, []).append(below)
    sizes = {number: _size(_lines(node), node) for number, node in shown.items()}
    for at, (goal, sharer) in enumerate(references, 1):
        children.setdefault(sharer, []).append(-at)
        sizes[-at] = _size(_reference_lines(shown[goal]), shown[goal])
    below_some = {below for _, below in hanging}
    roots = [number for number in shown if number not in below_some]
    return lay_out(roots, children, sizes, level_gap=_LEVEL_GAP, row_width=_ROW_WIDTH)


def _is_near(layout: Layout, goal: int, sharer: int) -> bool:
    low, high = layout.places[goal], layout.places[sharer]
    is_next_level = 0 < low.y - high.y < 4 * _LEVEL_GAP
    return is_next_level and abs(low.x - high.x) < _FARTHEST


def _figure(node: TreeNode, place: Place, *, is_reference: bool) -> Figure:
    lines = _reference_lines(node) if is_reference else _lines(node)
    return Figure(node, lines, _size(lines, node), place, is_reference)


def _lines(node: TreeNode) -> tuple[str, ...]:
    name = shortened(clean(node.name), _COLUMNS)
    return (name, *wrapped(clean(node.args), _COLUMNS, lines=3))


def _reference_lines(node: TreeNode) -> tuple[str, ...]:
    return (*_lines(node), f"see n{node.number}")


def _size(lines: Sequence[str], node: TreeNode) -> Size:
    width = max(cells(line) for line in lines) * CHARACTER + (40 if node.is_goal else 22)
    height = len(lines) * LINE + (20 if node.is_goal else 14)
    return Size(max(width, 64.0), height)


def _link(
    shown: Mapping[int, TreeNode],
    layout: Layout,
    above: int,
    below: int,
    *,
    is_shared: bool = False,
) -> Link:
    start, end = layout.places[above], layout.places[below]
    foot = _size(_lines(shown[above]), shown[above]).height / 2
    head = _size(_lines(shown[below]), shown[below]).height / 2
    return Link(Place(start.x, start.y + foot), Place(end.x, end.y - head), is_shared)


def _link_to_reference(
    shown: Mapping[int, TreeNode], layout: Layout, references: Sequence[_Pair], at: int
) -> Link:
    goal, sharer = references[at - 1]
    start, end = layout.places[sharer], layout.places[-at]
    foot = _size(_lines(shown[sharer]), shown[sharer]).height / 2
    head = _size(_reference_lines(shown[goal]), shown[goal]).height / 2
    return Link(Place(start.x, start.y + foot), Place(end.x, end.y - head), is_shared=True)
