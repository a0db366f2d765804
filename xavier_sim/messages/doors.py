"""The doors of the simulated building."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Broadcast, Query


class DoorState(BaseModel):
    """One door of the building as it stands now.

    ``door`` is its own name, which tells the doors of a ``room`` apart; empty where it has none.
    """

    model_config = ConfigDict(frozen=True)

    room: str
    open: bool
    door: str = ""


class MoveDoor(Query[DoorState]):
    """Open or close the door of a room, the first if it has several, or a door by its own name.

    A door does not close on the robot: the answer says how it stands. Fails with
    ``unknown_room``.
    """

    wire_name = "xavierDoor"

    room: str = Field(max_length=64)
    open: bool


class WorldDoors(Query[list[DoorState]]):
    """Ask how every door stands."""

    wire_name = "xavierDoors"


class DoorMoved(Broadcast):
    """Somebody has opened or closed a door, at a simulated time in seconds since the epoch.

    ``door`` is its own name, which tells the doors of a ``room`` apart; empty where it has none.
    """

    wire_name = "xavierDoorMoved"

    room: str
    open: bool
    time: float
    door: str = ""
