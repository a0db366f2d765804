"""Walls and doors of a floor as line segments: the one list behind physics and sensors alike."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from xavier_sim.messages.floorplan import Corner, Door, FloorPlan, Space, SpaceKind

WALL_RADIUS = 0.02
"""Half the thickness of a wall in the physics, metres; rays meet its centre line."""

TOUCH = 1e-4
"""Lines nearer to each other than this, in metres, are one line."""

Floats = NDArray[np.float64]
Interval = tuple[float, float]
Axis = Literal["x", "y"]
Line = tuple[Axis, float]


@dataclass(frozen=True)
class Edge:
    """One side of a space: on the line ``axis == at``, over ``span`` along the other axis."""

    axis: Axis
    at: float
    span: Interval


@dataclass(frozen=True)
class Geometry:
    """The segments of a floor.

    ``walls`` has shape (n, 4) and ``doors`` (m, 4): x0, y0, x1, y1 in metres. ``door_names``
    and ``door_rooms`` are in the order of ``doors``.
    """

    walls: Floats
    doors: Floats
    door_names: tuple[str, ...]
    door_rooms: tuple[str, ...]


def edges(space: Space) -> list[Edge]:
    """The four sides of a space: west, east, south, north."""
    low, high = space.low, space.high
    return [
        Edge("x", low.x, (low.y, high.y)),
        Edge("x", high.x, (low.y, high.y)),
        Edge("y", low.y, (low.x, high.x)),
        Edge("y", high.y, (low.x, high.x)),
    ]


def shared_edges(one: Space, other: Space) -> list[Edge]:
    """The stretches of border that two spaces share, none when they do not touch."""
    west_east = [(one.high.x, other.low.x), (one.low.x, other.high.x)]
    south_north = [(one.high.y, other.low.y), (one.low.y, other.high.y)]
    along_y = _overlap((one.low.y, one.high.y), (other.low.y, other.high.y))
    along_x = _overlap((one.low.x, one.high.x), (other.low.x, other.high.x))
    found = [Edge("x", a, along_y) for a, b in west_east if along_y and abs(a - b) < TOUCH]
    found += [Edge("y", a, along_x) for a, b in south_north if along_x and abs(a - b) < TOUCH]
    return found


def door_edge(door: Door, spaces: dict[str, Space]) -> Edge | None:
    """The gap that a door makes in the wall of its two spaces, None when it is in no such wall."""
    for edge in shared_edges(spaces[door.between[0]], spaces[door.between[1]]):
        across, along = (door.at.x, door.at.y) if edge.axis == "x" else (door.at.y, door.at.x)
        span = (along - door.width / 2, along + door.width / 2)
        inside = edge.span[0] - TOUCH <= span[0] and span[1] <= edge.span[1] + TOUCH
        if inside and abs(across - edge.at) < TOUCH:
            return Edge(edge.axis, edge.at, span)
    return None


def door_room(door: Door, spaces: dict[str, Space]) -> str:
    """The room that a door belongs to; the door's own name where it joins no room."""
    rooms = [name for name in door.between if spaces[name].kind is SpaceKind.ROOM]
    return rooms[0] if rooms else door.name


def space_at(plan: FloorPlan, x: float, y: float) -> Space | None:
    """The space that holds the point, if any."""
    for space in plan.spaces:
        if contains(space, Corner(x=x, y=y)):
            return space
    return None


def contains(space: Space, point: Corner) -> bool:
    """Whether the point lies in the space, its border included."""
    low, high = space.low, space.high
    return low.x <= point.x <= high.x and low.y <= point.y <= high.y


def build_geometry(plan: FloorPlan) -> Geometry:
    """Turn a valid plan into segments: borders, less openings between non-rooms, less doors."""
    spaces = {space.name: space for space in plan.spaces}
    gaps = [(door, door_edge(door, spaces)) for door in plan.doors]
    doors = [(door, gap) for door, gap in gaps if gap is not None]
    solid = _by_line([edge for space in plan.spaces for edge in edges(space)])
    holes = _by_line(_openings(plan) + [gap for _, gap in doors])
    walls = [
        _segment(Edge(axis, at, span))
        for (axis, at), spans in sorted(solid.items())
        for span in _subtract(_union(spans), holes.get((axis, at), []))
    ]
    return Geometry(
        walls=np.array(walls, dtype=np.float64).reshape(-1, 4),
        doors=np.array([_segment(gap) for _, gap in doors], dtype=np.float64).reshape(-1, 4),
        door_names=tuple(door.name for door, _ in doors),
        door_rooms=tuple(door_room(door, spaces) for door, _ in doors),
    )


def segment_distances(segments: Floats, x: float, y: float) -> Floats:
    """Metres from a point to each of the segments, shape (n,); ``segments`` has shape (n, 4)."""
    start = segments[:, :2]
    along = segments[:, 2:] - start
    to_point = np.array([x, y]) - start
    share = np.clip((to_point * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    apart = to_point - share[:, None] * along
    distances: Floats = np.hypot(apart[:, 0], apart[:, 1])
    return distances


def _openings(plan: FloorPlan) -> list[Edge]:
    open_spaces = [space for space in plan.spaces if space.kind is not SpaceKind.ROOM]
    return [
        edge
        for i, one in enumerate(open_spaces)
        for other in open_spaces[i + 1 :]
        for edge in shared_edges(one, other)
    ]


def _by_line(found: list[Edge]) -> dict[Line, list[Interval]]:
    lines: dict[Line, list[Interval]] = defaultdict(list)
    for edge in found:
        lines[edge.axis, round(edge.at / TOUCH) * TOUCH].append(edge.span)
    return lines


def _overlap(one: Interval, other: Interval) -> Interval | None:
    low, high = max(one[0], other[0]), min(one[1], other[1])
    return (low, high) if high - low > TOUCH else None


def _union(spans: list[Interval]) -> list[Interval]:
    merged: list[Interval] = []
    for low, high in sorted(spans):
        if merged and low <= merged[-1][1] + TOUCH:
            merged[-1] = (merged[-1][0], max(merged[-1][1], high))
        else:
            merged.append((low, high))
    return merged


def _subtract(spans: list[Interval], holes: list[Interval]) -> list[Interval]:
    left: list[Interval] = []
    for low, high in spans:
        start = low
        for hole_low, hole_high in _union(holes):
            if hole_high <= start or hole_low >= high:
                continue
            left.append((start, hole_low))
            start = hole_high
        left.append((start, high))
    return [(low, high) for low, high in left if high - low > TOUCH]


def _segment(edge: Edge) -> tuple[float, float, float, float]:
    low, high = edge.span
    return (edge.at, low, edge.at, high) if edge.axis == "x" else (low, edge.at, high, edge.at)
