"""Where people can walk: the spaces of a floor that are open to each other, and ways through."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from xavier_sim.floors import Edge, shared_edges
from xavier_sim.messages import FloorPlan, Space, SpaceKind

Point = tuple[float, float]


@dataclass(frozen=True)
class Opening:
    """Where one space goes over into another, ``to`` it."""

    to: str
    edge: Edge


class Walkways:
    """The corridors, foyers and lounges of a floor.

    People keep to them: rooms have doors, and whoever is in a room is in nobody's way.
    """

    def __init__(self, plan: FloorPlan) -> None:
        self.spaces = {s.name: s for s in plan.spaces if s.kind is not SpaceKind.ROOM}
        self._openings: dict[str, list[Opening]] = {name: [] for name in self.spaces}
        for one, other in combinations(self.spaces.values(), 2):
            for edge in shared_edges(one, other):
                self._openings[one.name].append(Opening(other.name, edge))
                self._openings[other.name].append(Opening(one.name, edge))
        self._areas = np.cumsum([_area(space) for space in self.spaces.values()])

    def space_at(self, x: float, y: float) -> str | None:
        """The open space that holds a point, None when none does."""
        for name, space in self.spaces.items():
            if space.low.x <= x <= space.high.x and space.low.y <= y <= space.high.y:
                return name
        return None

    def has_room(self, x: float, y: float, radius: float) -> bool:
        """Whether a disc at a point touches no wall."""
        name = self.space_at(x, y)
        if name is None:
            return False
        low, high = self.spaces[name].low, self.spaces[name].high
        sides = (
            ("x", low.x, x - low.x, y),
            ("x", high.x, high.x - x, y),
            ("y", low.y, y - low.y, x),
            ("y", high.y, high.y - y, x),
        )
        return all(
            off >= radius or self._is_open(name, axis, at, (along - radius, along + radius))
            for axis, at, off, along in sides
        )

    def random_point(self, random: np.random.Generator, radius: float) -> Point:
        """A point where a disc touches no wall, all as likely."""
        while True:
            share = float(random.random()) * float(self._areas[-1])
            space = list(self.spaces.values())[int(np.searchsorted(self._areas, share))]
            x = float(random.uniform(space.low.x, space.high.x))
            y = float(random.uniform(space.low.y, space.high.y))
            if self.has_room(x, y, radius):
                return x, y

    def way(self, start: Point, goal: Point, *, lane: float, radius: float) -> list[Point]:
        """Points to walk to in turn, ``goal`` the last; each leg lies in one space.

        Args:
            start: a point in an open space.
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
        return [_crossing(edge, lane, radius) for edge in crossed] + [goal]

    def _crossed(self, start: str, goal: str, width: float) -> list[Edge] | None:
        """The openings on the way with the fewest of them, None when there is no way."""
        came: dict[str, tuple[str, Edge]] = {}
        queue, seen = deque([start]), {start}
        while queue and goal not in seen:
            here = queue.popleft()
            for opening in self._openings[here]:
                low, high = opening.edge.span
                if opening.to not in seen and high - low > width:
                    seen.add(opening.to)
                    came[opening.to] = (here, opening.edge)
                    queue.append(opening.to)
        if goal not in seen:
            return None
        edges: list[Edge] = []
        while goal != start:
            goal, edge = came[goal]
            edges.append(edge)
        return edges[::-1]

    def _is_open(self, space: str, axis: str, at: float, span: tuple[float, float]) -> bool:
        return any(
            opening.edge.axis == axis
            and abs(opening.edge.at - at) < 1e-6
            and opening.edge.span[0] <= span[0]
            and span[1] <= opening.edge.span[1]
            for opening in self._openings[space]
        )


def _area(space: Space) -> float:
    return (space.high.x - space.low.x) * (space.high.y - space.low.y)


def _crossing(edge: Edge, lane: float, radius: float) -> Point:
    low, high = edge.span[0] + radius, edge.span[1] - radius
    along = low + lane * (high - low)
    return (edge.at, along) if edge.axis == "x" else (along, edge.at)
