"""How far it is from room to room: asked of the navigator once for all that are new."""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Iterable, Mapping

from navigate.messages import MOST_ROOMS, PlanRoutes, RouteTable
from tca_bus import Module, TcaError

log = logging.getLogger(__name__)


class Distances:
    """Metres of the route between two rooms; the straight line where no route is known yet."""

    def __init__(self, module: Module) -> None:
        self._module = module
        self._rooms: Mapping[str, tuple[float, float]] = {}
        self._metres: dict[frozenset[str], float] = {}

    def __call__(self, start: str, end: str) -> float:
        """Metres between two rooms; 0 for a room that is not on the map."""
        known = self._metres.get(frozenset((start, end)))
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
        known = sorted(set(rooms) & set(locations))[:MOST_ROOMS]
        pairs = itertools.combinations(known, 2)
        if all(frozenset(pair) in self._metres for pair in pairs):
            return
        try:
            table = await self._module.query(PlanRoutes(rooms=known))
        except TcaError as error:
            log.debug("no distances among %s: %s", ", ".join(known), error)
        else:
            self._keep(table)

    def _keep(self, table: RouteTable) -> None:
        for start, row in zip(table.rooms, table.metres, strict=True):
            for end, metres in zip(table.rooms, row, strict=True):
                if metres is not None:
                    self._metres.setdefault(frozenset((start, end)), metres)
