"""Where people can walk: the open spaces of a floor, rooms whose doors are open, ways through."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from xavier_sim.floors import Edge, door_edge, shared_edges
from xavier_sim.messages import FloorPlan, Space, SpaceKind

Point = tuple[float, float]

DOORWAY = 0.7
"""A door must be so wide, in metres, for somebody to walk through."""

BEFORE_DOOR = 0.45
"""People line up with a door so many metres before it, and walk on as far behind it."""

OFF_DOOR = 1.6
"""Who is in a room stays so many metres off its doors, out of the way of who comes in."""

TRIES = 20

MOST_DRAWS = 10_000
"""Points of the open spaces that are tried before none is taken to have room."""

CELL = 1.0
"""Metres along a side of the squares by which spaces are looked up."""


@dataclass(frozen=True)
class Opening:
    """Where one space goes over into another, ``to`` it, by the ``door`` of that number if any."""

    to: str
    edge: Edge
    door: int | None = None


class _Side(NamedTuple):
    """A side of a space as seen from a point: ``off`` metres, and where ``along`` it."""

    axis: str
    at: float
    off: float
    along: float


class NoSpotError(LookupError):
    """No open space has room for a disc of a ``radius``, metres."""

    def __init__(self, radius: float) -> None:
        self.radius = radius
        super().__init__(f"no open space has room for a disc of {radius:g} m radius")


class Walkways:
    """The corridors, foyers and lounges of a floor, and the rooms beside them.

    Doors begin open. Nobody goes through a room on the way to somewhere else.
    """

    def __init__(self, plan: FloorPlan) -> None:
        everywhere = {space.name: space for space in plan.spaces}
        self.spaces = {n: s for n, s in everywhere.items() if s.kind is not SpaceKind.ROOM}
        self.rooms = {n: s for n, s in everywhere.items() if s.kind is SpaceKind.ROOM}
        self._sides = {
            name: (space.low.x, space.low.y, space.high.x, space.high.y)
            for name, space in {**self.spaces, **self.rooms}.items()
        }
        self._in_cell: dict[tuple[int, int], list[str]] = {}
        self._openings: dict[str, list[Opening]] = {name: [] for name in everywhere}
        self._shut: set[int] = set()
        for one, other in combinations(self.spaces.values(), 2):
            for edge in shared_edges(one, other):
                self._join(one.name, other.name, edge)
        gaps = [(door.between, door_edge(door, everywhere)) for door in plan.doors]
        for number, (between, gap) in enumerate((b, gap) for b, gap in gaps if gap is not None):
            self._join(*between, gap, number)
        self._areas = np.cumsum([_area(space) for space in self.spaces.values()])

    def see_door(self, door: int, *, is_open: bool) -> None:
        """Let people through a door of the plan, or not."""
        if is_open:
            self._shut.discard(door)
        else:
            self._shut.add(door)

    def space_at(self, x: float, y: float) -> str | None:
        """The space that holds a point, an open one before a room; None when none does."""
        cell = (math.floor(x / CELL), math.floor(y / CELL))
        names = self._in_cell.get(cell)
        if names is None:
            names = self._in_cell[cell] = self._names_in(cell)
        for name in names:
            low_x, low_y, high_x, high_y = self._sides[name]
            if low_x <= x <= high_x and low_y <= y <= high_y:
                return name
        return None

    def _names_in(self, cell: tuple[int, int]) -> list[str]:
        """The spaces that reach into a cell, in the order in which they are asked."""
        west, south = cell[0] * CELL, cell[1] * CELL
        return [
            name
            for name, (low_x, low_y, high_x, high_y) in self._sides.items()
            if low_x <= west + CELL and west <= high_x and low_y <= south + CELL and south <= high_y
        ]

    def room_at(self, x: float, y: float) -> str | None:
        """The room that holds a point, None when none does."""
        name = self.space_at(x, y)
        return name if name in self.rooms else None

    def doors_of(self, room: str) -> list[Point]:
        """The middles of the open doors of a room, metres."""
        return [_middle(one.edge) for one in self._openings[room] if self._lets_through(one)]

    def has_room(self, x: float, y: float, radius: float) -> bool:
        """Whether a disc at a point touches no wall and no shut door."""
        name = self.space_at(x, y)
        if name is None:
            return False
        low_x, low_y, high_x, high_y = self._sides[name]
        if min(x - low_x, high_x - x, y - low_y, high_y - y) >= radius:
            return True
        return all(
            off >= radius or self._is_open(name, axis, at, (along - radius, along + radius))
            for axis, at, off, along in self._sides_around(name, x, y)
        )

    def is_beside_wall(self, x: float, y: float, *, within: float) -> bool:
        """Whether there is a wall no more than so many metres off, at right angles to it."""
        name = self.space_at(x, y)
        return name is not None and any(
            off <= within and not self._leads_on(name, axis, at, along)
            for axis, at, off, along in self._sides_around(name, x, y)
        )

    def _sides_around(self, name: str, x: float, y: float) -> tuple[_Side, ...]:
        low_x, low_y, high_x, high_y = self._sides[name]
        return (
            _Side("x", low_x, x - low_x, y),
            _Side("x", high_x, high_x - x, y),
            _Side("y", low_y, y - low_y, x),
            _Side("y", high_y, high_y - y, x),
        )

    def random_point(self, random: np.random.Generator, radius: float) -> Point:
        """A point of the open spaces where a disc touches no wall, all as likely.

        Raises:
            NoSpotError: there seems to be none: no open space is so wide.
        """
        for _ in range(MOST_DRAWS if self.spaces else 0):
            share = float(random.random()) * float(self._areas[-1])
            space = list(self.spaces.values())[int(np.searchsorted(self._areas, share))]
            x = float(random.uniform(space.low.x, space.high.x))
            y = float(random.uniform(space.low.y, space.high.y))
            if self.has_room(x, y, radius):
                return x, y
        raise NoSpotError(radius)

    def room_point(self, random: np.random.Generator, room: str, radius: float) -> Point | None:
        """A point in a room where a disc is in nobody's way; None when none is found."""
        low_x, low_y, high_x, high_y = self._sides[room]
        doors = [_middle(opening.edge) for opening in self._openings[room]]
        for _ in range(TRIES):
            x, y = float(random.uniform(low_x, high_x)), float(random.uniform(low_y, high_y))
            off_doors = all(math.dist(door, (x, y)) > OFF_DOOR for door in doors)
            if off_doors and self.has_room(x, y, radius):
                return x, y
        return None

    def way(self, start: Point, goal: Point, *, lane: float, radius: float) -> list[Point]:
        """Points to walk to in turn, ``goal`` the last.

        Args:
            start: a point in a space.
            goal: likewise.
            lane: where to cross openings, from 0 at one end to 1 at the other.
            radius: of whoever walks.

        Returns:
            Nothing when there is no way.
        """
        one, other = self.space_at(*start), self.space_at(*goal)
        if one is None or other is None:
            return []
        crossed = self._crossed(one, other, 2.0 * radius)
        if crossed is None:
            return []
        points = [point for opening in crossed for point in self._crossing(opening, lane, radius)]
        return [*points, goal]

    def _crossed(self, start: str, goal: str, width: float) -> list[Opening] | None:
        """The openings on the way with the fewest of them, None when there is no way."""
        came: dict[str, tuple[str, Opening]] = {}
        queue, seen = deque([start]), {start}
        while queue and goal not in seen:
            here = queue.popleft()
            for opening in self._openings[here]:
                leads_on = opening.to == goal or opening.to in self.spaces
                if opening.to not in seen and leads_on and self._is_wide(opening, width):
                    seen.add(opening.to)
                    came[opening.to] = (here, opening)
                    queue.append(opening.to)
        if goal not in seen:
            return None
        crossed: list[Opening] = []
        while goal != start:
            goal, opening = came[goal]
            crossed.append(opening)
        return crossed[::-1]

    def _is_wide(self, opening: Opening, width: float) -> bool:
        low, high = opening.edge.span
        least = width if opening.door is None else DOORWAY
        return high - low > least and self._lets_through(opening)

    def _lets_through(self, opening: Opening) -> bool:
        return opening.door is None or opening.door not in self._shut

    def _crossing(self, opening: Opening, lane: float, radius: float) -> list[Point]:
        """The point at which an opening is crossed; of a door one before it and one behind."""
        edge = opening.edge
        if opening.door is None:
            return [_on(edge, edge.at, _across(edge.span, lane, radius))]
        low_x, low_y, high_x, high_y = self._sides[opening.to]
        middle = (low_x + high_x) / 2 if edge.axis == "x" else (low_y + high_y) / 2
        behind, along = math.copysign(BEFORE_DOOR, middle - edge.at), sum(edge.span) / 2
        return [_on(edge, edge.at - behind, along), _on(edge, edge.at + behind, along)]

    def _join(self, one: str, other: str, edge: Edge, door: int | None = None) -> None:
        self._openings[one].append(Opening(other, edge, door))
        self._openings[other].append(Opening(one, edge, door))

    def _leads_on(self, space: str, axis: str, at: float, along: float) -> bool:
        """Whether a point of a side belongs to an opening, be it shut or not."""
        return any(
            opening.edge.axis == axis
            and abs(opening.edge.at - at) < 1e-6
            and opening.edge.span[0] <= along <= opening.edge.span[1]
            for opening in self._openings[space]
        )

    def _is_open(self, space: str, axis: str, at: float, span: tuple[float, float]) -> bool:
        return any(
            opening.edge.axis == axis
            and abs(opening.edge.at - at) < 1e-6
            and opening.edge.span[0] <= span[0]
            and span[1] <= opening.edge.span[1]
            and self._lets_through(opening)
            for opening in self._openings[space]
        )


def _area(space: Space) -> float:
    return (space.high.x - space.low.x) * (space.high.y - space.low.y)


def _across(span: tuple[float, float], lane: float, radius: float) -> float:
    low, high = span[0] + radius, span[1] - radius
    return low + lane * (high - low)


def _on(edge: Edge, at: float, along: float) -> Point:
    """The point ``at`` the edge's axis, and ``along`` the other."""
    return (at, along) if edge.axis == "x" else (along, at)


def _middle(edge: Edge) -> Point:
    return _on(edge, edge.at, sum(edge.span) / 2)
