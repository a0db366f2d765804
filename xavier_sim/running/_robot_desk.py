"""What the robot answers and takes beside driving: truth, doors, plates, battery, faults."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from tca_bus import Context, Module, TaskError
from xavier_sim.floors import UnknownDoorError
from xavier_sim.messages import (
    Battery,
    BatteryState,
    DoorMoved,
    DoorState,
    Fault,
    FaultState,
    MoveDoor,
    PlateReading,
    ReadFaults,
    ReadPlate,
    ShowWorld,
    WorldView,
)
from xavier_sim.running._faults import make_fault
from xavier_sim.running._outlet import Outlet
from xavier_sim.sensors import NoSensorError
from xavier_sim.truth_desk import TruthDesk
from xavier_sim.world import NotFreeError

if TYPE_CHECKING:
    from xavier_sim.running._robot_state import RobotState


class RobotDesk:
    """Serves the questions about a world, and the commands that change it between two ticks.

    Args:
        state: the world and its time.
        module: that serves.
        outlet: where to tell what all should hear.
        changed: called after the world was changed by a command.
    """

    def __init__(
        self, state: RobotState, module: Module, outlet: Outlet, changed: Callable[[], None]
    ) -> None:
        self._state, self._outlet, self._changed = state, outlet, changed
        self._told: BatteryState | None = None
        self._doors = state.world.each_door
        TruthDesk(state, module)
        module.serve(ShowWorld, self._on_world)
        module.serve(MoveDoor, self._on_move_door)
        module.serve(ReadPlate, self._on_read_plate)
        module.serve(Fault, self._on_fault)
        module.serve(ReadFaults, self._on_faults)

    async def tell_news(self) -> None:
        """Broadcast which doors have moved, and the battery's state when it is worth it.

        It is at every hundredth and at every change.
        """
        await self._tell_doors()
        state = self._state.battery_state()
        if self._told is not None and not _differ(self._told, state):
            return
        self._told = state
        await self._outlet.broadcast(Battery(state=state))

    async def _tell_doors(self) -> None:
        """Tell of doors whoever listens here: they may have been moved from another realm."""
        before, now = self._doors, self._state.world.each_door
        if before is now or before == now:
            return
        self._doors = now
        for old, new in zip(before, now, strict=True):
            if old != new:
                name, room, is_open = new
                moved = DoorMoved(room=room, open=is_open, time=self._state.now, door=name)
                await self._outlet.broadcast(moved)

    async def _on_world(self, _query: ShowWorld, _context: Context) -> WorldView:
        return self._state.world_view()

    async def _on_move_door(self, query: MoveDoor, _context: Context) -> DoorState:
        try:
            door = self._state.world.set_door(query.room, is_open=query.open)
        except UnknownDoorError as error:
            raise TaskError("unknown_room", str(error), data={"near": error.near}) from error
        self._changed()
        await self._tell_doors()
        return DoorState(room=door.room, open=door.is_open, door=door.name)

    async def _on_read_plate(self, _query: ReadPlate, _context: Context) -> PlateReading:
        if not self._state.robot.camera.is_on:
            raise TaskError("camera_gone", "the camera does not answer")
        look = self._state.robot.look(self._state.world.tick)
        reading = PlateReading(text=look.text, confidence=look.confidence, time=self._state.now)
        self._outlet.note(reading)
        return reading

    async def _on_faults(self, _query: ReadFaults, _context: Context) -> FaultState:
        return self._state.fault_state()

    async def _on_fault(self, query: Fault, _context: Context) -> FaultState:
        try:
            make_fault(self._state.world, query.fault, self._state.name)
        except UnknownDoorError as error:
            raise TaskError("unknown_room", str(error), data={"near": error.near}) from error
        except NotFreeError as error:
            raise TaskError("not_free", str(error)) from error
        except NoSensorError as error:
            raise TaskError("no_sensor", str(error)) from error
        self._outlet.note(query)
        self._changed()
        return self._state.fault_state()


def _differ(one: BatteryState, other: BatteryState) -> bool:
    same = (one.low, one.charging) == (other.low, other.charging)
    return not same or round(one.charge, 2) != round(other.charge, 2)
