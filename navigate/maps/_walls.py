"""Walls and passages of a floor plan: what its rectangles and doors mean for a robot.

A surveyed plan has errors of some centimetres, so rectangles that should touch overlap a little
or leave a gap; everything here is within `TOUCH`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from xavier_sim.messages import Door, FloorPlan, Space, SpaceKind

TOUCH = 0.25
"""Metres within which two rectangles count as touching."""

MIN_WALL = 0.12
"""Metres of wall below which a piece is a survey error and is dropped."""

MIN_OPENING = 0.7
"""Metres of open floor between two spaces below which nobody passes."""

Floats = NDArray[np.float64]

Point = tuple[float, float]
"""x, y in metres in the map frame."""


class Edge(NamedTuple):
    """One side of a rectangle: a vertical one lies at x = ``at``, between y ``low``..``high``."""

    vertical: bool
    at: float
    low: float
    high: float
    outward: int


@dataclass(frozen=True, slots=True)
class Passage:
    """A way between two spaces: a door, or open floor.

    ``normal`` is the unit vector from the first space into the second across the wall line at
    ``centre``; it is (0, 0) where the two rectangles really overlap.
    """

    name: str
    spaces: tuple[str, str]
    centre: tuple[float, float]
    normal: tuple[float, float]
    width: float
    door: bool

    def segment(self) -> tuple[float, float, float, float]:
        """The line across the passage from jamb to jamb: x0, y0, x1, y1 in metres."""
        (x, y), (nx, ny), half = self.centre, self.normal, self.width / 2
        return (x - ny * half, y + nx * half, x + ny * half, y - nx * half)

    @property
    def jambs(self) -> tuple[Point, Point]:
        """The two ends of that line."""
        x0, y0, x1, y1 = self.segment()
        return (x0, y0), (x1, y1)


def edges(space: Space) -> tuple[Edge, Edge, Edge, Edge]:
    """The four sides of a space."""
    low, high = space.low, space.high
    return (
        Edge(True, low.x, low.y, high.y, -1),
        Edge(True, high.x, low.y, high.y, 1),
        Edge(False, low.y, low.x, high.x, -1),
        Edge(False, high.y, low.x, high.x, 1),
    )


def wall_segments(plan: FloorPlan) -> Floats:
    """Derive the walls: an array (n, 4) of x0, y0, x1, y1, all parallel to an axis."""
    doors = [passage for passage in map_passages(plan) if passage.door]
    pieces: list[tuple[float, float, float, float]] = []
    for space in plan.spaces:
        for edge in edges(space):
            cuts = [*_open_cuts(plan, space, edge), *_door_cuts(doors, space, edge)]
            for low, high in _remaining(edge.low, edge.high, cuts):
                at = edge.at
                pieces.append((at, low, at, high) if edge.vertical else (low, at, high, at))
    return np.array(pieces, dtype=np.float64).reshape(-1, 4)


def map_passages(plan: FloorPlan) -> list[Passage]:
    """All doors and all open borders between spaces that are not rooms."""
    spaces = {space.name: space for space in plan.spaces}
    passages = [doorway(door, spaces) for door in plan.doors]
    common = [space for space in plan.spaces if space.kind is not SpaceKind.ROOM]
    for index, one in enumerate(common):
        for other in common[index + 1 :]:
            passages += _openings(one, other)
    return passages


def doorway(door: Door, spaces: dict[str, Space]) -> Passage:
    """The passage that a door is."""
    one, other = (spaces[name] for name in door.between)
    gap_x = max(one.low.x, other.low.x) - min(one.high.x, other.high.x)
    gap_y = max(one.low.y, other.low.y) - min(one.high.y, other.high.y)
    normal = _towards(one, other, 0 if gap_x > gap_y else 1)
    return Passage(door.name, door.between, (door.at.x, door.at.y), normal, door.width, True)


def _openings(one: Space, other: Space) -> list[Passage]:
    """Passages through the open border of two spaces, one every three metres or so of it."""
    low = (max(one.low.x, other.low.x), max(one.low.y, other.low.y))
    high = (min(one.high.x, other.high.x), min(one.high.y, other.high.y))
    span = (high[0] - low[0], high[1] - low[1])
    if min(span) < -TOUCH or max(span) < MIN_OPENING:
        return []
    centre = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
    name = f"{one.name}/{other.name}"
    if min(span) > TOUCH:
        return [Passage(name, (one.name, other.name), centre, (0.0, 0.0), min(span), False)]
    across = 0 if span[0] < span[1] else 1
    normal = _towards(one, other, across)
    passages = []
    for part, width in _shares(span[1 - across]):
        along, at = low[1 - across] + part, centre[across]
        spot = (at, along) if across == 0 else (along, at)
        passages.append(Passage(name, (one.name, other.name), spot, normal, width, False))
    return passages


def _shares(length: float) -> list[tuple[float, float]]:
    count = max(1, round(length / 3.0))
    width = length / count
    return [((index + 0.5) * width, width) for index in range(count)]


def _towards(one: Space, other: Space, across: int) -> tuple[float, float]:
    """The unit vector along axis ``across`` from one space to the other."""
    if across == 0:
        return (float(np.sign(other.low.x + other.high.x - one.low.x - one.high.x)), 0.0)
    return (0.0, float(np.sign(other.low.y + other.high.y - one.low.y - one.high.y)))


def _open_cuts(plan: FloorPlan, space: Space, edge: Edge) -> list[tuple[float, float]]:
    if space.kind is SpaceKind.ROOM:
        return []
    cuts = []
    for other in plan.spaces:
        if other.kind is SpaceKind.ROOM or other.name == space.name:
            continue
        across, along = _spans(other, vertical=edge.vertical)
        reach = across[1] if edge.outward > 0 else -across[0]
        near = across[0] if edge.outward > 0 else -across[1]
        line = edge.at * edge.outward
        if near <= line + TOUCH and reach > line + TOUCH:
            cuts.append((max(edge.low, along[0]), min(edge.high, along[1])))
    return [cut for cut in cuts if cut[1] - cut[0] >= MIN_OPENING]


def _door_cuts(doors: list[Passage], space: Space, edge: Edge) -> list[tuple[float, float]]:
    cuts = []
    for door in doors:
        across, along = door.centre if edge.vertical else door.centre[::-1]
        faces = (door.normal[0] != 0.0) == edge.vertical
        if space.name in door.spaces and faces and abs(across - edge.at) < TOUCH + 0.05:
            cuts.append((along - door.width / 2, along + door.width / 2))
    return cuts


def _spans(space: Space, *, vertical: bool) -> tuple[tuple[float, float], tuple[float, float]]:
    x, y = (space.low.x, space.high.x), (space.low.y, space.high.y)
    return (x, y) if vertical else (y, x)


def _remaining(
    low: float, high: float, cuts: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    pieces, at = [], low
    for start, end in sorted(cuts):
        pieces.append((at, start))
        at = max(at, end)
    pieces.append((at, high))
    return [(start, end) for start, end in pieces if end - start >= MIN_WALL]
