"""How far it is between many places: one search from each, over the graph of the planner."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass

from navigate.maps import Point
from navigate.messages import RouteTable
from navigate.routes._graph import straight
from navigate.routes._hindrances import Hindrances
from navigate.routes._routes import Planner

MOST_KEPT = 300
"""Searches that are kept, one for each place that distances were asked from."""


@dataclass(frozen=True, slots=True)
class Reach:
    """What it costs to get somewhere by the fastest way."""

    seconds: float
    metres: float


@dataclass(frozen=True, slots=True)
class _Origin:
    """A start: the space that it is in, None in a doorway, and what the search from it found."""

    at: Point
    space: str | None
    reached: dict[int, Reach]


@dataclass(frozen=True, slots=True)
class _End:
    """A goal: the space that it is in, and the ways to it from the nodes of that space."""

    at: Point
    space: str
    legs: list[tuple[int, Reach]]


class Distances:
    """Distances by the fastest ways; searches are kept while what is in the way stays the same."""

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self._blocked = Hindrances()
        self._origins: dict[Point, _Origin] = {}

    def between(
        self, starts: Sequence[Point], goals: Sequence[Point], blocked: Hindrances
    ) -> list[list[Reach | None]]:
        """From each start to each goal, in metres; None where there is no way.

        They are the lengths of the routes that `Planner.plan` finds one by one.
        """
        if blocked != self._blocked or len(self._origins) > MOST_KEPT:
            self._blocked, self._origins = blocked, {}
        origins = [self._origin(start) for start in starts]
        ends = [self._end(goal) for goal in goals]
        return [[self._reach(origin, end) for end in ends] for origin in origins]

    def _origin(self, start: Point) -> _Origin:
        if start not in self._origins:
            space = self._planner.space_of(start)
            self._origins[start] = _Origin(start, space, self._spread(start))
        return self._origins[start]

    def _end(self, goal: Point) -> _End | None:
        planner = self._planner
        if not planner.is_reachable(goal):
            return None
        space = planner.floor.space_nearest(*goal).name
        nodes = planner.graph.nodes
        legs = [
            (node, Reach(seconds, math.dist(nodes[node].at, goal)))
            for node, seconds in planner.ways_out(goal, self._blocked).items()
        ]
        return _End(goal, space, legs)

    def _reach(self, origin: _Origin, end: _End | None) -> Reach | None:
        if end is None:
            return None
        same = origin.space == end.space
        if same and self._planner.is_direct(origin.at, end.at, self._blocked):
            metres = math.dist(origin.at, end.at)
            return Reach(straight(metres), metres)
        ways = [
            Reach(reached.seconds + leg.seconds, reached.metres + leg.metres)
            for node, leg in end.legs
            if (reached := origin.reached.get(node))
        ]
        return min(ways, key=lambda way: way.seconds, default=None)

    def _spread(self, start: Point) -> dict[int, Reach]:
        """Dijkstra's search from a point to every node that can be reached."""
        graph, blocked = self._planner.graph, self._blocked
        reached: dict[int, Reach] = {}
        queue = [
            (seconds, node, math.dist(start, graph.nodes[node].at))
            for node, seconds in self._planner.ways_in(start, blocked).items()
        ]
        heapq.heapify(queue)
        while queue:
            seconds, node, metres = heapq.heappop(queue)
            if node in reached:
                continue
            reached[node] = Reach(seconds, metres)
            for other, link in graph.around[node]:
                cost = self._planner.cost(link, other, blocked)
                if other not in reached and cost < math.inf:
                    heapq.heappush(queue, (seconds + cost, other, metres + link.metres))
        return reached


def as_table(rooms: list[str], found: list[list[Reach | None]]) -> RouteTable:
    """Distances from each of the rooms, and in the last row from here, as `PlanRoutes` answers."""
    metres = [[None if way is None else round(way.metres, 2) for way in row] for row in found]
    seconds = [[None if way is None else round(way.seconds, 1) for way in row] for row in found]
    return RouteTable(rooms=rooms, metres=metres[:-1], seconds=seconds[:-1], from_here=metres[-1])
