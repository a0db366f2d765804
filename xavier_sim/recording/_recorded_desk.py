"""What a recorded robot answers beside driving: what was recorded, and that it is a recording."""

from __future__ import annotations

from typing import NoReturn, Protocol

from tca_bus import Context, Module, TaskError
from xavier_sim.messages import (
    BatteryState,
    DoorState,
    Fault,
    FaultState,
    MoveDoor,
    PlateReading,
    ReadBattery,
    ReadPlate,
    TrueLocation,
    WhereReally,
    WorldDoors,
)


class Recorded(Protocol):
    """A recording at one of its ticks."""

    def true_location(self) -> TrueLocation:
        """Where the robot really was."""

    def door_states(self) -> list[DoorState]:
        """How the doors stood."""

    def battery_state(self) -> BatteryState:
        """How full the battery was."""

    def plate(self) -> PlateReading | None:
        """What the camera read at this tick, None if nobody asked it then."""


class RecordedDesk:
    """Serves the questions about a recorded robot; nothing in it can be changed."""

    def __init__(self, robot: Recorded, module: Module) -> None:
        self._robot = robot
        module.serve(WhereReally, self._on_where)
        module.serve(WorldDoors, self._on_doors)
        module.serve(ReadBattery, self._on_battery)
        module.serve(ReadPlate, self._on_plate)
        module.serve(MoveDoor, self._on_move_door)
        module.serve(Fault, self._on_fault)

    async def tell_news(self) -> None:
        """What the robot said is told with its ticks."""

    async def _on_where(self, _query: WhereReally, _context: Context) -> TrueLocation:
        return self._robot.true_location()

    async def _on_doors(self, _query: WorldDoors, _context: Context) -> list[DoorState]:
        return self._robot.door_states()

    async def _on_battery(self, _query: ReadBattery, _context: Context) -> BatteryState:
        return self._robot.battery_state()

    async def _on_plate(self, _query: ReadPlate, _context: Context) -> PlateReading:
        reading = self._robot.plate()
        if reading is None:
            raise TaskError("camera_gone", "at this tick of the recording nobody asked the camera")
        return reading

    async def _on_move_door(self, _query: MoveDoor, _context: Context) -> DoorState:
        _refuse()

    async def _on_fault(self, _query: Fault, _context: Context) -> FaultState:
        _refuse()


def _refuse() -> NoReturn:
    raise TaskError("recorded", "this robot is a recording: nothing in it can be changed")
