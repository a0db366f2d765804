"""Routes between places, without driving them."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from navigate.messages.places import RoomName
from tca_bus import Query

MOST_ROOMS = 200
"""Rooms that one `PlanRoutes` may name."""


class Route(BaseModel):
    """A path: way points in metres, the spaces and doors it passes, its length and time."""

    model_config = ConfigDict(frozen=True)

    points: list[tuple[float, float]]
    via: list[str]
    metres: float
    seconds: float


class PlanRoute(Query[Route]):
    """Ask for the best route from one place to another; from here when ``start`` is empty."""

    wire_name = "navigateRoute"

    goal: RoomName
    start: RoomName | None = None


class RouteTable(BaseModel):
    """How far it is between places.

    ``metres[i][j]`` and ``seconds[i][j]`` lead from ``rooms[i]`` to ``rooms[j]``, ``from_here[j]``
    metres from where the robot is to ``rooms[j]``; None where there is no way.
    """

    model_config = ConfigDict(frozen=True)

    rooms: list[str]
    metres: list[list[float | None]]
    seconds: list[list[float | None]]
    from_here: list[float | None]


class PlanRoutes(Query[RouteTable]):
    """Ask how far it is between each two of some rooms, as the navigator knows the floor now.

    With ``as_built`` what is in the way now, such as a shut door, does not count, and the answer
    is always the same.
    """

    wire_name = "navigateRoutes"

    rooms: list[RoomName] = Field(max_length=MOST_ROOMS)
    as_built: bool = False
