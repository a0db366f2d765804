"""Messages that the navigate module serves.

Map locations are in the papers' map units, read as centimetres; everything else is SI.
"""

from navigate.messages.drives import (
    DriveProgress,
    NavigateToGoal,
    NavigationFailure,
    NavigationOutcome,
    NavigationReport,
    Progress,
    StopDriving,
)
from navigate.messages.localizers import LocalizerName
from navigate.messages.outlook import Outlook, ShowOutlook
from navigate.messages.places import RoomLocation, RoomName, Rooms, ShowMap, WhereIsRoom
from navigate.messages.position import (
    MOST_CELLS,
    Belief,
    BeliefCell,
    BeliefState,
    Believed,
    Look,
    NoticeLandmark,
    Position,
    SetPosition,
    Sight,
    WhereAmI,
)
from navigate.messages.routes import MOST_ROOMS, PlanRoute, PlanRoutes, Route, RouteTable

__all__ = [
    "MOST_CELLS",
    "MOST_ROOMS",
    "Belief",
    "BeliefCell",
    "BeliefState",
    "Believed",
    "DriveProgress",
    "LocalizerName",
    "Look",
    "NavigateToGoal",
    "NavigationFailure",
    "NavigationOutcome",
    "NavigationReport",
    "NoticeLandmark",
    "Outlook",
    "PlanRoute",
    "PlanRoutes",
    "Position",
    "Progress",
    "RoomLocation",
    "RoomName",
    "Rooms",
    "Route",
    "RouteTable",
    "SetPosition",
    "ShowMap",
    "ShowOutlook",
    "Sight",
    "StopDriving",
    "WhereAmI",
    "WhereIsRoom",
]
