"""Planning on a map alone, without the navigator."""

from __future__ import annotations

from navigate.maps import Floor, load_plan
from navigate.messages import Route
from navigate.routes import NoRouteError, Planner, describe
from tca_bus import Failure, HandlerFailedError


def plan_offline(start: str, goal: str, source: str) -> Route:
    """The best route on a map where every door is open.

    Raises:
        MapError: The map cannot be read.
        UnknownRoomError: It has no such room.
        HandlerFailedError: No way leads there.
    """
    floor = Floor(load_plan(source))
    begin, end = floor.place(start), floor.place(goal)
    try:
        return describe(begin, Planner(floor).plan(begin, end))
    except NoRouteError as error:
        raise HandlerFailedError(Failure(name="no_route", text=str(error))) from error
