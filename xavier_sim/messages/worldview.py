"""How things really stand in the simulated world, for those who look on."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from tca_bus import Query
from xavier_sim.messages.doors import DoorState
from xavier_sim.messages.floorplan import FloorPlan
from xavier_sim.messages.robot import TrueLocation


class Standing(BaseModel):
    """Somebody or something upright on the floor, as a disc in metres."""

    model_config = ConfigDict(frozen=True)

    x: float
    y: float
    radius: float
    person: bool


class WorldView(BaseModel):
    """The building, its doors, where the robot really is, and who and what stands about."""

    model_config = ConfigDict(frozen=True)

    floor: FloorPlan
    doors: list[DoorState]
    robot: TrueLocation
    standing: list[Standing]


class ShowWorld(Query[WorldView]):
    """Ask the simulator for all of it at once: for people who look, and for tests."""

    wire_name = "xavierWorld"
