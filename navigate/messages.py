"""Messages that the navigate module serves.

Map locations are in the papers' map units, read as centimetres; everything else is SI.
"""

from __future__ import annotations

import enum
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Command, Goal, Query

RoomName = Annotated[str, Field(max_length=64)]
"""A room as the map calls it, such as ``r-5303``."""


MOST_ROOMS = 200
"""Rooms that one `PlanRoutes` may name."""


class NavigationFailure(enum.StrEnum):
    """Why `NavigateToGoal` failed: the names of its failures on the bus."""

    BUMP = "bump"
    """Contacts that backing out did not cure."""
    CORRIDOR_BLOCKED = "corridor_blocked"
    """Something stands in the corridor, and there is no way round."""
    DOOR_BLOCKED = "door_blocked"
    """The door on the way is closed or obstructed."""
    LOST = "lost"
    """The position estimate fell apart."""
    NO_PROGRESS = "no_progress"
    """The robot did not get nearer for too long."""
    NO_ROUTE = "no_route"
    """The map has no way there."""


class Position(BaseModel):
    """Where the navigator believes the robot to be.

    Metres and radians in the map frame; ``deviation`` is the standard deviation of the position
    in metres, ``heading_deviation`` that of the heading in radians; ``room`` is the room at
    whose place it stands, if any, and ``confidence`` how probable it is, 0 to 1, that it really
    stands there.
    """

    model_config = ConfigDict(frozen=True)

    x: float
    y: float
    theta: float
    deviation: float
    heading_deviation: float
    room: str | None
    confidence: float = Field(default=0.0, ge=0.0, le=1.0)
    time: float


class NavigationReport(BaseModel):
    """What a drive came to: the result of `NavigateToGoal`, and the data of its failures."""

    model_config = ConfigDict(frozen=True)

    position: Position
    metres: float
    seconds: float
    recoveries: int


class NavigateToGoal(Goal[NavigationReport]):
    """Drive to a map location (``x``, ``y`` in map units, that is centimetres).

    Succeeds when the navigator believes to be there; fails with a `NavigationFailure` name and
    a `NavigationReport` as data. Source: Haigh & Veloso, section 4.
    """

    wire_name = "navigateToG"

    x: float = Field(allow_inf_nan=False, description="map units (cm)")
    y: float = Field(allow_inf_nan=False, description="map units (cm)")


class WhereAmI(Query[Position]):
    """Ask for the position estimate."""

    wire_name = "navigateWhere"


class SetPosition(Command[Position]):
    """Tell the navigator that the robot stands at ``room``, as a person said."""

    wire_name = "C_setPosition"

    room: RoomName


class RoomLocation(BaseModel):
    """A room and the map location of its place, in map units (cm)."""

    model_config = ConfigDict(frozen=True)

    room: str
    x: float
    y: float


class WhereIsRoom(Query[RoomLocation]):
    """Ask for the map location of a room."""

    wire_name = "navigateRoom"

    room: RoomName


class Rooms(Query[list[RoomLocation]]):
    """Ask for all rooms of the map."""

    wire_name = "navigateRooms"


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
    """Ask how far it is between each two of some rooms, as the navigator knows the floor now."""

    wire_name = "navigateRoutes"

    rooms: list[RoomName] = Field(max_length=MOST_ROOMS)
