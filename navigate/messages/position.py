"""Where the robot is believed to be, and what others can say or ask about that."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from navigate.messages.places import RoomName
from tca_bus import Command, Query


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


class WhereAmI(Query[Position]):
    """Ask for the position estimate."""

    wire_name = "navigateWhere"


class SetPosition(Command[Position]):
    """Tell the navigator that the robot stands at ``room``, as a person said."""

    wire_name = "C_setPosition"

    room: RoomName
