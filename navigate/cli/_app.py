"""The command line ``navigate``."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from navigate.maps import Floor, UnknownRoomError, load_plan
from navigate.messages import PlanRoute, Position, Rooms, Route, WhereAmI
from navigate.position import LocalizerName, make_localizer
from navigate.routes import NoRouteError, Planner, describe
from tca_bus import Failure, HandlerFailedError, Module, configure_logging
from tca_bus.cli import (
    DEFAULT_FLAGS,
    BusFlags,
    bus_options,
    emit,
    emit_json,
    make_app,
    run_app,
    show_table,
)

app = make_app("navigate", help="Find the way, know the place, drive the robot.")


@app.command
async def run(
    *,
    map: Annotated[str | None, Parameter(env_var="NAVIGATE_MAP")] = None,  # noqa: A002 - the flag
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    localizer: LocalizerName = "particles",
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the navigator until it is stopped.

    Args:
        map: Floor plan file, or the name of one that comes with the package.
        seed: Of the position estimate's random numbers, 0 or more.
        localizer: What estimates the position: a particle filter, or odometry alone.
        data: Folder in which the position is kept for the next start.
        flags: Shared flags.
    """
    from navigate.keeping import StateFile  # noqa: PLC0415 - only the process itself needs numpy
    from navigate.navigator import Navigator  # noqa: PLC0415 - same
    from navigate.service import NavigateService  # noqa: PLC0415 - same

    configure_logging("navigate", level=flags.level, json=flags.json)
    floor = Floor(load_plan(map))
    navigator = Navigator(floor, localizer=make_localizer(localizer, floor, seed=seed))
    kept = StateFile(data) if data else None
    await NavigateService(navigator, bus_options(flags), kept).run()


@app.command
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
    route = _plan_offline(start, goal, map) if map else await _plan_online(start, goal, flags)
    if flags.json:
        emit_json(route)
    else:
        _show_route(route)


@app.command
async def where(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show where the robot believes to be.

    Args:
        flags: Shared flags.
    """
    async with Module(_client_name(), options=bus_options(flags)) as module:
        position = await module.query(WhereAmI())
    if flags.json:
        emit_json(position)
    else:
        _show_position(position)


def main() -> None:
    """Run the command line."""
    run_app(app)


def _plan_offline(start: str, goal: str, source: str) -> Route:
    floor = Floor(load_plan(source))
    begin, end = floor.place(start), floor.place(goal)
    try:
        return describe(begin, Planner(floor).plan(begin, end))
    except NoRouteError as error:
        raise HandlerFailedError(Failure(name="no_route", text=str(error))) from error


async def _plan_online(start: str, goal: str, flags: BusFlags) -> Route:
    async with Module(_client_name(), options=bus_options(flags)) as module:
        known = {location.room for location in await module.query(Rooms())}
        for room in (start, goal):
            if room.lower() not in known:
                raise UnknownRoomError(room, sorted(known))
        return await module.query(PlanRoute(start=start, goal=goal))


def _client_name() -> str:
    return f"navigate-{os.getpid()}"


def _show_route(route: Route) -> None:
    emit(f"{route.metres:.1f} m, about {route.seconds:.0f} s, by {' - '.join(route.via)}")
    show_table(["x", "y"], [[f"{x:.2f}", f"{y:.2f}"] for x, y in route.points])


def _show_position(position: Position) -> None:
    emit(
        f"({position.x:.2f}, {position.y:.2f}) m, heading {position.theta:.2f} rad, "
        f"give or take {position.deviation:.2f} m and {position.heading_deviation:.2f} rad"
        + (f", at {position.room} ({position.confidence:.0%} sure)" if position.room else "")
    )
