"""How far it is from room to room: asked of the navigator for many at a time.

What is in the way now does not count, so that whoever asks at another time plans the same; an
errand that meets a shut door is put off.
"""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Iterable, Mapping, Sequence

from navigate.messages import MOST_ROOMS, PlanRoutes, RouteTable
from tca_bus import Module, TcaError

log = logging.getLogger(__name__)


class Distances:
    """Metres of the route between two rooms; the straight line where no route is known yet."""

    def __init__(self, module: Module) -> None:
        self._module = module
        self._rooms: Mapping[str, tuple[float, float]] = {}
        self._metres: dict[tuple[str, str], float] = {}
        self._told: set[tuple[str, str]] = set()

    def __call__(self, start: str, end: str) -> float:
        """Metres between two rooms; 0 for a room that is not on the map."""
        known = self._metres.get((start, end))
        if known is not None:
            return known
        if start not in self._rooms or end not in self._rooms:
            return 0.0
        return math.dist(self._rooms[start], self._rooms[end])

    async def learn(
        self, rooms: Iterable[str], locations: Mapping[str, tuple[float, float]]
    ) -> None:
        """Ask for the routes among ``rooms``; ``locations`` are those of all rooms, in metres."""
        self._rooms = locations
        named = sorted(set(rooms) & set(locations))
        if any(pair not in self._told for pair in itertools.permutations(named, 2)):
            # More than the navigator answers at once come in pieces, two of which meet each time.
            size = MOST_ROOMS // 2
            pieces = [named[at : at + size] for at in range(0, len(named), size)]
            for one, other in itertools.combinations_with_replacement(pieces, 2):
                await self._ask(one if one is other else one + other)

    async def _ask(self, rooms: Sequence[str]) -> None:
        try:
            table = await self._module.query(PlanRoutes(rooms=list(rooms), as_built=True))
        except TcaError as error:
            log.debug("no routes among %s: %s", ", ".join(rooms), error)
        else:
            self._keep(table)

    def _keep(self, table: RouteTable) -> None:
        for start, row in zip(table.rooms, table.metres, strict=True):
            for end, metres in zip(table.rooms, row, strict=True):
                self._told.add((start, end))
                if metres is not None:
                    self._metres[start, end] = metres
