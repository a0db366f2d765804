"""Questions about the map: rooms, routes, distances."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager

from navigate.maps import UnknownRoomError
from navigate.messages import (
    NavigationFailure,
    PlanRoute,
    PlanRoutes,
    RoomLocation,
    Rooms,
    Route,
    RouteTable,
    ShowMap,
    WhereIsRoom,
)
from navigate.navigator import Navigator
from navigate.routes import Hindrances, NoRouteError, as_table, describe
from tca_bus import Context, Module, TaskError
from xavier_sim.messages import FloorPlan


@contextmanager
def told_unknown() -> Iterator[None]:
    """Fail with a name that callers can tell when the map has no such room."""
    try:
        yield
    except UnknownRoomError as error:
        raise TaskError("unknown_room", str(error), data={"near": error.near}) from error


class MapDesk:
    """Serves what can be asked of the map as the navigator knows it now."""

    def __init__(self, navigator: Navigator, module: Module) -> None:
        self._navigator = navigator
        self._measuring = asyncio.Lock()
        module.serve(ShowMap, self._on_map)
        module.serve(WhereIsRoom, self._on_room)
        module.serve(Rooms, self._on_rooms)
        module.serve(PlanRoute, self._on_plan)
        module.serve(PlanRoutes, self._on_plan_many)

    async def _on_map(self, _query: ShowMap, _context: Context) -> FloorPlan:
        return self._navigator.floor.plan

    async def _on_room(self, query: WhereIsRoom, _context: Context) -> RoomLocation:
        with told_unknown():
            return self._navigator.floor.location(query.room)

    async def _on_rooms(self, _query: Rooms, _context: Context) -> list[RoomLocation]:
        floor = self._navigator.floor
        return [floor.location(room) for room in floor.places]

    async def _on_plan(self, query: PlanRoute, _context: Context) -> Route:
        navigator = self._navigator
        floor, here = navigator.floor, navigator.localizer.estimate
        with told_unknown():
            start = floor.place(query.start) if query.start else (here.x, here.y)
            goal = floor.place(query.goal)
        hindrances = navigator.memory.believed(navigator.time)
        try:
            steps = navigator.planner.plan(start, goal, hindrances)
        except NoRouteError as error:
            raise TaskError(NavigationFailure.NO_ROUTE, str(error)) from error
        return describe(start, steps)

    async def _on_plan_many(self, query: PlanRoutes, _context: Context) -> RouteTable:
        navigator = self._navigator
        here = navigator.localizer.estimate
        with told_unknown():
            places = [navigator.floor.place(room) for room in query.rooms]
        hindrances = Hindrances() if query.as_built else navigator.memory.believed(navigator.time)
        starts = [*places, (here.x, here.y)]
        # In a thread: the wheels go on being answered meanwhile.
        async with self._measuring:
            find = navigator.distances.between
            found = await asyncio.to_thread(find, starts, places, hindrances)
        return as_table(query.rooms, found)
