"""The topological graph of a floor: stand-off points before and behind every passage.

In a rectangle every two points see each other, so all stand-offs of one space are joined by
straight lines; the two of one passage are joined through it. Stand-offs in a corridor lie on
its centre line, and so do the ways between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from navigate.maps import Floor, Passage, Point, is_room
from xavier_sim.messages import Space

CORRIDOR_STANDOFF = 1.2
"""Metres before a passage from which the robot faces it, in corridors and halls."""

ROOM_STANDOFF = 0.7
"""The same inside a room: where its place is."""

CRUISE = 0.5
"""Metres per second along a corridor, for the cost of a link."""

DOOR_SECONDS = 10.0
"""What facing, measuring and creeping through a door costs beside the distance."""

MISS_PER_METRE, MOST_MISSED = 0.004, 0.25
"""Probability of missing a turn for each metre of the straight way before it, and at most."""

MISS_SECONDS = 20.0
"""What it costs to notice a missed turn, and to go back to it."""


def show_point(point: Point) -> str:
    """A point in metres, for people; short however far off it is."""
    return f"({point[0]:.5g}, {point[1]:.5g})"


@dataclass(frozen=True, slots=True)
class Node:
    """A point where ways meet: the stand-off of ``passage``, across ``normal``, in ``space``."""

    at: Point
    space: str
    passage: str
    normal: Point = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Link:
    """A straight way between two nodes (by index), through ``door`` if that is named.

    ``missing`` are the seconds that missing the turn at ``one``, and at ``other``, costs on the
    average.
    """

    one: int
    other: int
    metres: float
    seconds: float
    door: str | None = None
    missing: tuple[float, float] = (0.0, 0.0)

    def seconds_to(self, node: int) -> float:
        """What going to one of its nodes costs on the average."""
        return self.seconds + self.missing[node == self.other]


class Graph:
    """Nodes and links of a floor; ``at`` maps a space to the indices of its nodes."""

    def __init__(self, nodes: list[Node], links: list[Link]) -> None:
        self.nodes = nodes
        self.links = links
        self.at: dict[str, list[int]] = {}
        for index, node in enumerate(nodes):
            self.at.setdefault(node.space, []).append(index)
        self.around: list[list[tuple[int, Link]]] = [[] for _ in nodes]
        for link in links:
            self.around[link.one].append((link.other, link))
            self.around[link.other].append((link.one, link))

    def before(self, room: str) -> list[Point]:
        """The stand-off points outside the doors of a room."""
        mine = {self.nodes[index].passage for index in self.at.get(room, [])}
        return [node.at for node in self.nodes if node.passage in mine and node.space != room]


def build_graph(floor: Floor) -> Graph:
    """Build the graph of ``floor``."""
    nodes: list[Node] = []
    links: list[Link] = []
    for passage in floor.passages:
        pair = [_standoff(floor, passage, side) for side in (0, 1)]
        nodes += pair
        links.append(_through(passage, len(nodes) - 2, pair[0], pair[1]))
    return Graph(nodes, links + list(_across(nodes)))


def nodes_of(number: int) -> tuple[int, int]:
    """The indices of the two nodes of a floor's passage, by its number."""
    return 2 * number, 2 * number + 1


def straight(metres: float) -> float:
    """Seconds for a straight way of ``metres``, with a little for turning at its end."""
    return metres / CRUISE + (1.0 if metres > 0.1 else 0.0)


def missing(start: Point, node: Node) -> float:
    """Seconds that it costs on the average to miss the turn at a node on the way from a point.

    Dead reckoning errs by a share of the way, so a turn is missed the more easily the longer
    the straight way before it; nobody misses a passage that lies straight ahead.
    """
    dx, dy = node.at[0] - start[0], node.at[1] - start[1]
    metres = math.hypot(dx, dy)
    if abs(dx * node.normal[0] + dy * node.normal[1]) >= 0.7 * metres:
        return 0.0
    return min(MOST_MISSED, MISS_PER_METRE * metres) * MISS_SECONDS


def _standoff(floor: Floor, passage: Passage, side: int) -> Node:
    space = floor.spaces[passage.spaces[side]]
    (x, y), (nx, ny) = passage.centre, passage.normal
    sign = 1.0 if side else -1.0
    away = _away(space, passage) * sign
    return Node((x + nx * away, y + ny * away), space.name, passage.name, passage.normal)


def _away(space: Space, passage: Passage) -> float:
    depth = space.high.x - space.low.x if passage.normal[0] else space.high.y - space.low.y
    return min(ROOM_STANDOFF if is_room(space) else CORRIDOR_STANDOFF, depth / 2)


def _through(passage: Passage, first: int, one: Node, other: Node) -> Link:
    metres = math.dist(one.at, other.at)
    if passage.door:
        return Link(first, first + 1, metres, straight(metres) + DOOR_SECONDS, passage.name)
    return Link(first, first + 1, metres, straight(metres))


def _across(nodes: list[Node]) -> Iterable[Link]:
    for index, one in enumerate(nodes):
        for number in range(index + 1, len(nodes)):
            if (other := nodes[number]).space == one.space:
                metres = math.dist(one.at, other.at)
                missed = missing(other.at, one), missing(one.at, other)
                yield Link(index, number, metres, straight(metres), missing=missed)
