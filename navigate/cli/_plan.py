"""``navigate plan``: the best route between two rooms."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from navigate.cli._naming import client_name
from navigate.messages import PlanRoute, Rooms, Route
from tca_bus import Module, TcaError
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options, emit, emit_json, show_table


async def plan(
    start: Annotated[str, Parameter(name="FROM")],
    goal: Annotated[str, Parameter(name="TO")],
    /,
    *,
    map: Annotated[str | None, Parameter(env_var="NAVIGATE_MAP")] = None,  # noqa: A002 - the flag
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Show the best route between two rooms, as the navigator knows the floor now.

    Args:
        start: Room to begin at.
        goal: Room to go to.
        map: Plan on this map, without the navigator.
        flags: Shared flags.
    """
    if map:
        from navigate.cli._offline import plan_offline  # noqa: PLC0415 - others need no numpy

        route = plan_offline(start, goal, map)
    else:
        route = await _plan_online(start, goal, flags)
    if flags.json:
        emit_json(route)
    else:
        _show_route(route)


async def _plan_online(start: str, goal: str, flags: BusFlags) -> Route:
    async with Module(client_name(), options=bus_options(flags)) as module:
        known = {location.room for location in await module.query(Rooms())}
        for room in (start, goal):
            if room.lower() not in known:
                raise _no_such_room(room, sorted(known))
        return await module.query(PlanRoute(start=start, goal=goal))


def _no_such_room(room: str, known: list[str]) -> TcaError:
    from navigate.maps import UnknownRoomError  # noqa: PLC0415 - no other answer needs numpy

    return UnknownRoomError(room, known)


def _show_route(route: Route) -> None:
    emit(f"{route.metres:.1f} m, about {route.seconds:.0f} s, by {' - '.join(route.via)}")
    show_table(["x", "y"], [[f"{x:.2f}", f"{y:.2f}"] for x, y in route.points])
