"""Rooms and their places on the map."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Query
from xavier_sim.messages import FloorPlan

RoomName = Annotated[str, Field(max_length=64)]
"""A room as the map calls it, such as ``r-5303``."""


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


class ShowMap(Query[FloorPlan]):
    """Ask for the whole map that the navigator goes by, in metres."""

    wire_name = "navigateMap"
