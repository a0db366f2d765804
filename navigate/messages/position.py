"""Where the robot is believed to be, and what others can say or ask about that."""

from __future__ import annotations

import math

from pydantic import BaseModel, ConfigDict, Field

from navigate.messages.places import RoomName
from tca_bus import Broadcast, Command, Query

MOST_TURN = 2.0 * math.pi
"""Radians of a heading at most, either way."""

MOST_CELLS = 64
"""Cells that a `Belief` tells at most: the most probable ones."""


class Position(BaseModel):
    """Where the navigator believes the robot to be.

    Metres and radians in the map frame; ``deviation`` is the standard deviation of the position
    in metres, ``heading_deviation`` that of the heading in radians; ``room`` is the room at
    whose place it stands, if any, and ``confidence`` how probable it is, 0 to 1, that it really
    stands there. ``lost`` says that the navigator would not drive on it: the robot may be
    elsewhere, whatever the deviation. Without ``heard`` no robot has sent readings since the
    navigator started: all of it is what the map, an earlier run or a person says.
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
    lost: bool = False
    heard: bool = True


class WhereAmI(Query[Position]):
    """Ask for the position estimate."""

    wire_name = "navigateWhere"


class SetPosition(Command[Position]):
    """Tell the navigator that the robot stands at ``room``, as a person said.

    ``theta`` is where it looks, radians in the map frame, counter-clockwise from east; unless it is
    said, it looks where it was believed to look, or where the sonars fit. Fails with
    ``unknown_room``.
    """

    wire_name = "C_setPosition"

    room: RoomName
    theta: float | None = Field(default=None, allow_inf_nan=False, ge=-MOST_TURN, le=MOST_TURN)


class NoticeLandmark(Command[Position]):
    """Tell the navigator that the robot sees the door plate of ``room``, more or less surely.

    Belief moves towards the door of that room, the more so the surer the sight: with
    ``confidence`` 0.5 not at all. Unlike `SetPosition` it overrules nothing that the navigator
    is sure of. Fails with ``unknown_room``.
    """

    wire_name = "C_noticeLandmark"

    room: RoomName
    confidence: float = Field(default=0.9, gt=0.0, lt=1.0)


class Sight(BaseModel):
    """What the camera reads, beside what the navigator believes.

    ``plate`` is the room on the door plate that is seen, None for none, with the ``confidence``
    of its reader; ``expected`` is the share of belief, 0 to 1, from where that plate could be
    seen; 0.0 without one.
    """

    model_config = ConfigDict(frozen=True)

    plate: str | None
    confidence: float = Field(ge=0.0, le=1.0)
    expected: float = Field(ge=0.0, le=1.0)
    position: Position


class Look(Query[Sight]):
    """Have the camera look round for a door plate.

    Fails with ``no_camera`` where nothing handles one, and ``camera_gone`` where it is dead, or
    does not answer in time. If the router goes meanwhile it ends as any query does.
    """

    wire_name = "navigateLook"


class BeliefCell(BaseModel):
    """A cell of one metre by one of four headings, with its share of the belief.

    ``x``, ``y`` and ``theta`` are the middle of what is believed in it, metres and radians.
    """

    model_config = ConfigDict(frozen=True)

    x: float
    y: float
    theta: float
    mass: float = Field(ge=0.0, le=1.0)


class BeliefState(BaseModel):
    """The belief about where the robot is.

    ``entropy`` is in bits over all cells, 0 for a robot that is sure of its cell; ``cells`` are
    the most probable `MOST_CELLS`, best first. ``goal_mass`` is the share of belief at the goal
    under way, None without one; ``lost`` says that the navigator would not drive on it.
    """

    model_config = ConfigDict(frozen=True)

    position: Position
    entropy: float = Field(ge=0.0)
    lost: bool
    goal_mass: float | None = Field(default=None, ge=0.0, le=1.0)
    cells: tuple[BeliefCell, ...] = Field(max_length=MOST_CELLS)


class Believed(Query[BeliefState]):
    """Ask for the whole belief."""

    wire_name = "navigateBelieved"


class Belief(Broadcast):
    """The belief, once a simulated second while it changes, and when a drive begins or ends."""

    wire_name = "navigateBelief"

    state: BeliefState
