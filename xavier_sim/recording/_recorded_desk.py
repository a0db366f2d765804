"""What a recorded robot answers beside driving: what was recorded, and that it is a recording."""

from __future__ import annotations

from typing import NoReturn, Protocol

from tca_bus import Context, Module, TaskError
from xavier_sim.messages import DoorState, Fault, FaultState, MoveDoor, PlateReading, ReadPlate
from xavier_sim.truth_desk import Truth, TruthDesk


class Recorded(Truth, Protocol):
    """A recording at one of its ticks."""

    def plate(self) -> PlateReading | None:
        """What the camera read at this tick, None if nobody asked it then."""


class RecordedDesk:
    """Serves the questions about a recorded robot; nothing in it can be changed."""

    def __init__(self, robot: Recorded, module: Module) -> None:
        self._robot = robot
        TruthDesk(robot, module)
        module.serve(ReadPlate, self._on_plate)
        module.serve(MoveDoor, self._on_move_door)
        module.serve(Fault, self._on_fault)

    async def tell_news(self) -> None:
        """What the robot said is told with its ticks."""

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
