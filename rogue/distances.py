"""How far it is from room to room: asked of the navigator once for each pair."""

from __future__ import annotations

import asyncio
import itertools
import logging
import math
from collections.abc import Iterable, Mapping

from navigate.messages import PlanRoute
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
        pairs = (frozenset(pair) for pair in itertools.combinations(sorted(set(rooms)), 2))
        unknown = [pair for pair in pairs if pair not in self._metres]
        await asyncio.gather(*(self._ask(pair) for pair in unknown))

    async def _ask(self, pair: frozenset[str]) -> None:
        start, end = sorted(pair)
        try:
            route = await self._module.query(PlanRoute(start=start, goal=end))
        except TcaError as error:
            log.debug("no route from %s to %s: %s", start, end, error)
        else:
            self._metres[pair] = route.metres
