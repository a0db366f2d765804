"""Where the boxes of a forest stand: tidy trees, side by side in rows.

The trees are laid out as Reingold and Tilford do it (Tidier drawings of trees, IEEE TSE 7(2),
1981): a parent stands over the middle of its children, subtrees are moved together until their
outlines nearly touch, and what is drawn of a subtree does not depend on where it hangs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

GAP = 18.0
"""Pixels between neighbours."""

TREE_GAP = 44.0
"""Pixels between trees, and between rows of them."""


@dataclass(frozen=True, slots=True)
class Size:
    """Width and height of a box, in pixels."""

    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Place:
    """The middle of a box, in pixels from the upper left corner of the drawing."""

    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Layout:
    """Where each box stands, and the extent of the whole."""

    places: Mapping[int, Place]
    extent: Size


@dataclass(slots=True)
class _Tree:
    """A subtree: left and right outline by level, and x by box, all relative to its root."""

    lefts: list[float]
    rights: list[float]
    xs: dict[int, float]


def lay_out(
    roots: Sequence[int],
    children: Mapping[int, Sequence[int]],
    sizes: Mapping[int, Size],
    *,
    level_gap: float,
    row_width: float,
) -> Layout:
    """Return the places of the boxes below ``roots``.

    Args:
        roots: The tops of the trees, in the order in which they stand.
        children: What hangs below each box, from left to right; a box hangs below one at most.
        sizes: Of every box.
        level_gap: Pixels between the levels of a tree.
        row_width: Pixels after which the next tree begins a new row; a wider tree has its own.
    """
    places: dict[int, Place] = {}
    left = top = width = row_height = 0.0
    for root in roots:
        tree, levels = _tidy(root, children, sizes), _levels(root, children)
        tree_width = max(tree.rights) - min(tree.lefts)
        if left and left + tree_width > row_width:
            left, top, row_height = 0.0, top + row_height + TREE_GAP, 0.0
        ys, height = _heights(levels, sizes, level_gap)
        for level, boxes in enumerate(levels):
            for box in boxes:
                places[box] = Place(left - min(tree.lefts) + tree.xs[box], top + ys[level])
        width = max(width, left + tree_width)
        left += tree_width + TREE_GAP
        row_height = max(row_height, height)
    return Layout(places, Size(width, top + row_height))


def _levels(root: int, children: Mapping[int, Sequence[int]]) -> list[list[int]]:
    levels = [[root]]
    while below := [child for box in levels[-1] for child in children.get(box, ())]:
        levels.append(below)
    return levels


def _heights(
    levels: Sequence[Sequence[int]], sizes: Mapping[int, Size], gap: float
) -> tuple[list[float], float]:
    """The middle of each level, and the height of all."""
    middles: list[float] = []
    top = 0.0
    for boxes in levels:
        height = max(sizes[box].height for box in boxes)
        middles.append(top + height / 2)
        top += height + gap
    return middles, top - gap


def _tidy(root: int, children: Mapping[int, Sequence[int]], sizes: Mapping[int, Size]) -> _Tree:
    done: dict[int, _Tree] = {}
    for boxes in reversed(_levels(root, children)):
        for box in boxes:
            half = sizes[box].width / 2
            below = [done.pop(child) for child in children.get(box, ())]
            done[box] = _over(box, half, below)
    return done[root]


def _over(box: int, half: float, below: Sequence[_Tree]) -> _Tree:
    """A box over its subtrees, which are moved together from the left."""
    lefts: list[float] = []
    rights: list[float] = []
    xs: dict[int, float] = {}
    offsets: list[float] = []
    for tree in below:
        shared = zip(rights, tree.lefts, strict=False)
        offset = max((right - left + GAP for right, left in shared), default=0.0)
        offsets.append(offset)
        deeper = len(lefts)
        lefts += [left + offset for left in tree.lefts[deeper:]]
        rights[: len(tree.rights)] = [right + offset for right in tree.rights]
        xs |= {one: x + offset for one, x in tree.xs.items()}
    middle = (offsets[0] + offsets[-1]) / 2 if offsets else 0.0
    return _Tree(
        [-half, *(left - middle for left in lefts)],
        [half, *(right - middle for right in rights)],
        {box: 0.0} | {one: x - middle for one, x in xs.items()},
    )
