"""The topological map behind the Markov model: places, and ways of about so many metres.

A corridor is a row of places where doors and other corridors lead off, joined by edges whose
lengths are known only within bounds; rooms, foyers and lounges are fields of places a metre
apart; a door is a place of its own. After Simmons & Koenig, Probabilistic Robot Navigation in
Partially Observable Environments (1995): a topological map with approximate metric information.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

from navigate.maps import Floor, Passage, Point
from xavier_sim.messages import Space, SpaceKind

STRETCH = 0.1
"""Share of its length by which a corridor between two places may be longer or shorter."""

SLACK = 0.2
"""Metres that it may be longer or shorter besides."""

JOINED = 0.7
"""Metres along a corridor within which two places are one."""

PITCH = 1.0
"""Metres from place to place in rooms and foyers."""


class Kind(enum.Enum):
    """What a place is."""

    CORRIDOR = "corridor"
    DOOR = "door"
    FOYER = "foyer"
    ROOM = "room"


@dataclass(frozen=True, slots=True)
class Place:
    """A node of the map; ``space`` names the space, or the door, that it lies in."""

    kind: Kind
    space: str
    at: Point


@dataclass(frozen=True, slots=True)
class Edge:
    """A straight way between two places, by index, in direction ``heading`` from the first.

    ``heading`` counts quarters of a turn from east; ``chances`` maps each possible length, in
    cells of a metre, to its probability.
    """

    one: int
    other: int
    heading: int
    chances: dict[int, float]


@dataclass
class Topology:
    """Places and the edges between them."""

    places: list[Place] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)

    def add(self, place: Place) -> int:
        """Add a place; its index."""
        self.places.append(place)
        return len(self.places) - 1

    def join(self, one: int, other: int, *, bounds: tuple[int, int] | None = None) -> None:
        """Join two places by an edge; its length is what the map says, or within ``bounds``."""
        start, end = self.places[one].at, self.places[other].at
        metres = math.dist(start, end)
        chances = even(*bounds) if bounds else lengths(metres)
        self.edges.append(Edge(one, other, quarter(start, end), chances))


def even(least: int, most: int) -> dict[int, float]:
    """Lengths of ``least`` to ``most`` cells, all equally probable."""
    return dict.fromkeys(range(least, most + 1), 1.0 / (most - least + 1))


def lengths(metres: float) -> dict[int, float]:
    """The lengths in cells that a way of about so many ``metres`` may have."""
    doubt = STRETCH * metres + SLACK
    least, most = max(1, round(metres - doubt)), max(1, round(metres + doubt))
    weights = {
        cells: math.exp(-0.5 * ((cells - metres) / max(0.4, doubt)) ** 2)
        for cells in range(least, most + 1)
    }
    total = sum(weights.values())
    return {cells: weight / total for cells, weight in weights.items()}


def quarter(start: Point, end: Point) -> int:
    """The direction from one point to another, in quarters of a turn from east."""
    return round(math.atan2(end[1] - start[1], end[0] - start[0]) / (math.pi / 2)) % 4


def build_topology(floor: Floor) -> Topology:
    """The topological map of a floor."""
    topology = Topology()
    within: dict[str, list[int]] = {}
    for space in floor.plan.spaces:
        if space.kind is SpaceKind.CORRIDOR:
            within[space.name] = _row(topology, floor, space)
        else:
            within[space.name] = _field(topology, space)
    for passage in floor.passages:
        _connect(topology, passage, [within[name] for name in passage.spaces])
    return topology


def _row(topology: Topology, floor: Floor, space: Space) -> list[int]:
    """The places of a corridor, one after the other along its axis."""
    axis, middle, low, high = _axis(space)
    leads = [passage.centre[axis] for passage in floor.passages if space.name in passage.spaces]
    ends = [low + (high - low) / 2] if high - low < 2.0 else [low + 0.6, high - 0.6]
    row: list[int] = []
    for at in _thinned(sorted([*ends, *(min(max(lead, low + 0.2), high - 0.2) for lead in leads)])):
        point = (at, middle) if axis == 0 else (middle, at)
        row.append(topology.add(Place(Kind.CORRIDOR, space.name, point)))
    for one, other in pairwise(row):
        topology.join(one, other)
    return row


def _axis(space: Space) -> tuple[int, float, float, float]:
    """Which coordinate runs along a corridor, the other's middle, and where it begins and ends."""
    wide, tall = space.high.x - space.low.x, space.high.y - space.low.y
    if wide >= tall:
        return 0, (space.low.y + space.high.y) / 2, space.low.x, space.high.x
    return 1, (space.low.x + space.high.x) / 2, space.low.y, space.high.y


def _thinned(values: list[float]) -> Iterator[float]:
    """The middles of what lies within `JOINED` of each other."""
    group: list[float] = []
    for value in values:
        if group and value - group[0] > JOINED:
            yield sum(group) / len(group)
            group = []
        group.append(value)
    if group:
        yield sum(group) / len(group)


def _field(topology: Topology, space: Space) -> list[int]:
    """The places of a room or foyer, in rows and columns."""
    kind = Kind.ROOM if space.kind is SpaceKind.ROOM else Kind.FOYER
    xs = list(_spread(space.low.x, space.high.x))
    ys = list(_spread(space.low.y, space.high.y))
    spots = [[topology.add(Place(kind, space.name, (x, y))) for y in ys] for x in xs]
    for column in spots:
        for one, other in pairwise(column):
            topology.join(one, other, bounds=(1, 1))
    for left, right in pairwise(spots):
        for one, other in zip(left, right, strict=True):
            topology.join(one, other, bounds=(1, 1))
    return [spot for column in spots for spot in column]


def _spread(low: float, high: float) -> Iterator[float]:
    count = max(1, round((high - low) / PITCH))
    for index in range(count):
        yield low + (index + 0.5) * (high - low) / count


def _connect(topology: Topology, passage: Passage, sides: list[list[int]]) -> None:
    """Join the places on either side of a passage, through a place in its frame for a door."""
    nearest = [
        min(side, key=lambda index: math.dist(topology.places[index].at, passage.centre))
        for side in sides
    ]
    if not passage.door:
        topology.join(*nearest)
        return
    door = topology.add(Place(Kind.DOOR, passage.name, passage.centre))
    for index in nearest:
        topology.join(index, door, bounds=(1, 1))
