"""Driving to a goal: how it goes, what it comes to, and how to stop it.

Map locations are in the papers' map units, read as centimetres; everything else is SI.
"""

from __future__ import annotations

import enum
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from navigate.messages.places import RoomName
from navigate.messages.position import Position
from tca_bus import Broadcast, Goal, Query


class NavigationFailure(enum.StrEnum):
    """Why `NavigateToGoal` failed: the names of its failures on the bus."""

    BUMP = "bump"
    """Contacts that backing out did not cure."""
    CANCELLED = "cancelled"
    """Somebody stopped the robot with `StopDriving`."""
    CORRIDOR_BLOCKED = "corridor_blocked"
    """Something stands in the corridor, and there is no way round."""
    DOOR_BLOCKED = "door_blocked"
    """The door on the way is closed or obstructed."""
    LOST = "lost"
    """The position estimate fell apart."""
    NO_PROGRESS = "no_progress"
    """The robot did not get nearer for too long, or its wheels do not turn."""
    NO_ROUTE = "no_route"
    """The map has no way there."""


NavigationOutcome = Literal["arrived"] | NavigationFailure
"""How a drive ended."""


class NavigationReport(BaseModel):
    """What a drive came to: the result of `NavigateToGoal`, and the data of its failures.

    ``outcome`` says how it ended, ``position`` where the robot is believed to be then;
    ``goal_mass`` is the share of belief at the goal, 0 to 1, and ``entropy`` that of the belief in
    bits, None where nobody knows. A low share with ``arrived`` is a success to be doubted: look
    before you act on it. ``door`` is the room whose door ended it as ``door_blocked``: the goal's,
    or that of a room on the way, such as the one in which the robot is shut in.
    """

    model_config = ConfigDict(frozen=True)

    position: Position
    metres: float
    seconds: float
    recoveries: int
    outcome: NavigationOutcome = "arrived"
    goal_mass: float | None = Field(default=None, ge=0.0, le=1.0)
    entropy: float | None = Field(default=None, ge=0.0)
    door: RoomName | None = None


class NavigateToGoal(Goal[NavigationReport]):
    """Drive to a map location (``x``, ``y`` in map units, that is centimetres).

    Succeeds when the navigator believes to be there; fails with a `NavigationFailure` name and
    a `NavigationReport` as data. Source: Haigh & Veloso, section 4.
    """

    wire_name = "navigateToG"

    x: float = Field(allow_inf_nan=False, description="map units (cm)")
    y: float = Field(allow_inf_nan=False, description="map units (cm)")


class DriveProgress(BaseModel):
    """How a drive goes.

    ``task`` is the id of its `NavigateToGoal`, ``x`` and ``y`` its goal in map units (cm),
    ``room`` the room there, if any. ``metres_left`` and ``seconds_left`` are along the route,
    None while the robot plans or recovers; ``metres``, ``seconds`` and ``recoveries`` are what
    it took so far, ``goal_mass`` the share of belief at the goal. ``faults`` are the senses that
    are not believed, such as ``sonar 3``, with the reason: ``dead``, ``stuck`` or ``off``. While
    the robot is ``lost`` the figures that hang on its place mean little.
    """

    model_config = ConfigDict(frozen=True)

    task: str
    x: float
    y: float
    room: str | None
    metres_left: float | None = Field(ge=0.0)
    seconds_left: float | None = Field(ge=0.0)
    metres: float
    seconds: float
    recoveries: int
    goal_mass: float = Field(ge=0.0, le=1.0)
    time: float
    faults: dict[str, str] = {}
    lost: bool = False


class Progress(Broadcast):
    """How the drive under way goes, once a simulated second."""

    wire_name = "navigateProgress"

    drive: DriveProgress


class StopDriving(Query[Position]):
    """Stop the wheels now; a drive under way fails with ``cancelled``.

    Goes straight to the navigator, past the task tree, and answers with where the robot is.
    """

    wire_name = "navigateStop"
