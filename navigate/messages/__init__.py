"""Messages that the navigate module serves.

Map locations are in the papers' map units, read as centimetres; everything else is SI.
"""

from navigate.messages.drives import (
    NavigateToGoal,
    NavigationFailure,
    NavigationOutcome,
    NavigationReport,
    StopDriving,
)
from navigate.messages.places import RoomLocation, RoomName, Rooms, ShowMap, WhereIsRoom
from navigate.messages.position import (
    Position,
    SetPosition,
    WhereAmI,
)
from navigate.messages.routes import MOST_ROOMS, PlanRoute, PlanRoutes, Route, RouteTable

__all__ = [
    "MOST_ROOMS",
    "NavigateToGoal",
    "NavigationFailure",
    "NavigationOutcome",
    "NavigationReport",
    "PlanRoute",
    "PlanRoutes",
    "Position",
    "RoomLocation",
    "RoomName",
    "Rooms",
    "Route",
    "RouteTable",
    "SetPosition",
    "ShowMap",
    "StopDriving",
    "WhereAmI",
    "WhereIsRoom",
]
