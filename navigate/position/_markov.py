"""The Markov model: locations of one metre by four headings, and where motions lead.

An edge whose length is known only within bounds would be several chains of cells side by side,
one for each length. They are folded into two, one for each end that the robot may have come
from: a cell says how many metres ago the robot left that end, and at each cell from the shortest
length on the chain either goes on or arrives at the other end, with the chance that the edge is
just so long given that it is no shorter. After Koenig & Simmons, Xavier: A Robot Navigation
Architecture Based on Partially Observable Markov Decision Process Models (1998).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigate.maps import Floats, Point
from navigate.position._topology import Edge, Kind, Topology

TURNS = 4
"""Headings, in quarters of a turn from east."""

HOPS = (0.1, 0.8, 0.1)
"""Chances that a motion of one metre, as reported, was none, one or two cells."""

BLOCKED = 0.25
"""How likely a metre across a wall of the map is reported, by a robot that stays in its cell."""

BESIDE = 1.1
"""Metres from a place within which a robot in a chain may turn off as from the place itself."""

BESIDES = 0.5
"""Chance that it does, when it goes that way."""

TURNED = {0: 0.9, -1: 0.05, 1: 0.05}
"""Chances that a turn, as reported, fell short or went too far by so many quarters."""

Indices = NDArray[np.intp]
Chances = dict[int, float]
"""Probabilities of locations, by index."""


@dataclass(frozen=True, slots=True)
class Matrix:
    """A sparse matrix in compressed rows, one for each state that is entered.

    ``begins[i]`` is where row i begins in ``sources`` and ``values``; no row is empty.
    """

    begins: Indices
    sources: Indices
    values: Floats

    def __matmul__(self, vector: Floats) -> Floats:
        return np.asarray(np.add.reduceat(vector[self.sources] * self.values, self.begins))


@dataclass(frozen=True, slots=True)
class Locations:
    """Where the robot may be, but for its heading: the places of the map, then chains' cells.

    ``at`` has shape (n, 2), metres as the map has them; in a chain that may be longer than the
    map says, several lie at its end.
    """

    at: Floats
    kinds: tuple[Kind, ...]
    spaces: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.at)


class MarkovModel:
    """States and their transitions; state number ``heading * n + location``.

    Args:
        topology: the map.
    """

    def __init__(self, topology: Topology) -> None:
        self.topology = topology
        self._chains = _chains(topology)
        self.locations = _locations(topology, self._chains)
        self.hops = [self._hops(heading) for heading in range(TURNS)]
        motions = [_motions(hops) for hops in self.hops]
        self._moves = [_moves(motions, relative) for relative in range(TURNS)]
        self._leads = _leads(self.hops)

    @property
    def size(self) -> int:
        """How many states there are."""
        return TURNS * len(self.locations)

    def moved(self, belief: Floats, *, relative: int) -> Floats:
        """The belief after a motion of one metre, ``relative`` quarters left of the heading.

        It sums up to less than 1 where walls are in the way of what was believed.
        """
        return self._moves[relative] @ belief

    def ahead(self, costs: Floats) -> Floats:
        """The mean of ``costs`` a cell ahead of each state; a wall leads nowhere else."""
        return self._leads @ costs

    def turned(self, belief: Floats, *, quarters: int) -> Floats:
        """The belief after a turn to the left by so many quarters."""
        by_heading = belief.reshape(TURNS, -1)
        after = np.zeros_like(by_heading)
        for error, chance in TURNED.items():
            after += chance * np.roll(by_heading, quarters + error, axis=0)
        return after.ravel()

    def _hops(self, heading: int) -> list[Chances]:
        """Where one cell in a direction leads from each location."""
        leads: list[list[Chances]] = [[] for _ in range(len(self.locations))]
        across: list[tuple[Edge, list[int]]] = []
        for edge, (ahead, back) in zip(self.topology.edges, self._chains, strict=True):
            if edge.heading == heading:
                _go_on(leads, edge.one, ahead, edge.other, edge.chances)
                _go_back(leads, edge.other, back)
            elif (edge.heading + 2) % TURNS == heading:
                _go_on(leads, edge.other, back, edge.one, edge.chances)
                _go_back(leads, edge.one, ahead)
            else:
                across.append((edge, ahead + back))
        for edge, chain in across:
            self._turn_off(leads, edge, chain)
        return [_mean(options) if options else {i: BLOCKED} for i, options in enumerate(leads)]

    def _turn_off(self, leads: list[list[Chances]], edge: Edge, chain: list[int]) -> None:
        """Let what stands in a chain turn off into what its ends lead to."""
        for here in chain:
            for end in (edge.one, edge.other):
                metres = math.dist(self.locations.at[here], self.locations.at[end])
                if metres <= BESIDE and leads[end]:
                    option = {at: BESIDES * chance for at, chance in _mean(leads[end]).items()}
                    leads[here].append({**option, here: (1.0 - BESIDES) * BLOCKED})


def _chains(topology: Topology) -> list[tuple[list[int], list[int]]]:
    """The locations of both chains of each edge, in the order in which they are left behind."""
    chains, count = [], len(topology.places)
    for edge in topology.edges:
        inner = max(edge.chances) - 1
        middle = count + inner
        chains.append((list(range(count, middle)), list(range(middle, middle + inner))))
        count += 2 * inner
    return chains


def _locations(topology: Topology, chains: list[tuple[list[int], list[int]]]) -> Locations:
    at = [place.at for place in topology.places]
    kinds = [place.kind for place in topology.places]
    spaces = [place.space for place in topology.places]
    for edge, (ahead, back) in zip(topology.edges, chains, strict=True):
        one, other = topology.places[edge.one], topology.places[edge.other]
        at += _along(one.at, other.at, len(ahead))
        at += _along(other.at, one.at, len(back))
        kinds += [Kind.CORRIDOR] * 2 * len(ahead)
        spaces += [one.space] * 2 * len(ahead)
    return Locations(np.array(at, dtype=np.float64).reshape(-1, 2), tuple(kinds), tuple(spaces))


def _along(start: Point, end: Point, count: int) -> list[Point]:
    """Points a metre apart from one place towards another, none beyond it."""
    metres = max(math.dist(start, end), 1e-6)
    shares = [min(0.9, cells / metres) for cells in range(1, count + 1)]
    return [
        (start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]))
        for share in shares
    ]


def _go_on(
    leads: list[list[Chances]], start: int, chain: list[int], end: int, chances: dict[int, float]
) -> None:
    """Away from the end that a chain begins at: on, or to the other end."""
    left = 1.0
    for cells, here in enumerate([start, *chain], start=1):
        arrives = chances.get(cells, 0.0) / left if left > 1e-12 else 1.0
        left -= chances.get(cells, 0.0)
        options = {end: min(1.0, arrives)}
        if arrives < 1.0 and cells <= len(chain):
            options[chain[cells - 1]] = 1.0 - arrives
        leads[here].append(options)


def _go_back(leads: list[list[Chances]], start: int, chain: list[int]) -> None:
    """Back to the end that a chain begins at, after a turn within it."""
    for here, before in zip(chain, [start, *chain], strict=False):
        leads[here].append({before: 1.0})


def _mean(options: list[Chances]) -> Chances:
    mean: Chances = {}
    for option in options:
        for location, chance in option.items():
            mean[location] = mean.get(location, 0.0) + chance / len(options)
    return mean


class _Flat(NamedTuple):
    """Where motions lead: from ``start`` to ``to`` with a chance, one after the other."""

    locations: int
    start: Indices
    to: Indices
    chances: Floats


def _motions(hops: list[Chances]) -> _Flat:
    """Where a motion of about a metre in one direction leads from each location."""
    outcomes = [_motion(hops, location) for location in range(len(hops))]
    start = np.repeat(np.arange(len(hops)), [len(outcome) for outcome in outcomes])
    to = np.array([at for outcome in outcomes for at in outcome], dtype=np.intp)
    chances = np.array([chance for outcome in outcomes for chance in outcome.values()])
    return _Flat(len(hops), start, to, chances)


def _motion(hops: list[Chances], location: int) -> Chances:
    outcome: Chances = {location: HOPS[0]}
    for first, chance in hops[location].items():
        outcome[first] = outcome.get(first, 0.0) + HOPS[1] * chance
        for second, further in hops[first].items():
            outcome[second] = outcome.get(second, 0.0) + HOPS[2] * chance * further
    return outcome


def _leads(hops: list[list[Chances]]) -> Matrix:
    """Where going forward leads from each state, if anywhere."""
    sources, values = list[int](), list[float]()
    begins = []
    for heading, options in enumerate(hops):
        for location, leads in enumerate(options):
            begins.append(len(sources))
            passed = {at: chance for at, chance in leads.items() if at != location}
            total = sum(passed.values())
            sources += [heading * len(options) + at for at in passed or (location,)]
            values += [chance / total for chance in passed.values()] or [1.0]
    return Matrix(np.array(begins), np.array(sources), np.array(values))


def _moves(motions: list[_Flat], relative: int) -> Matrix:
    """The transitions of all states for a motion of a metre in a direction off the heading."""
    parts = [motions[(heading + relative) % TURNS] for heading in range(TURNS)]
    count = parts[0].locations
    rows = np.concatenate([part.to + heading * count for heading, part in enumerate(parts)])
    columns = np.concatenate([part.start + heading * count for heading, part in enumerate(parts)])
    values = np.concatenate([part.chances for part in parts])
    order = np.lexsort((columns, rows))
    begins = np.flatnonzero(np.diff(rows[order], prepend=-1))
    return Matrix(begins, columns[order], values[order])
