"""What any robot answers about how things really stand, simulated or recorded."""

from __future__ import annotations

from typing import Protocol

from tca_bus import Context, Module
from xavier_sim.messages import (
    BatteryState,
    DoorState,
    ReadBattery,
    TrueLocation,
    WhereReally,
    WorldDoors,
)


class Truth(Protocol):
    """A robot at one of its ticks, and the doors round it."""

    def true_location(self) -> TrueLocation:
        """Where the robot really is."""

    def door_states(self) -> list[DoorState]:
        """How the doors stand."""

    def battery_state(self) -> BatteryState:
        """How full the battery is."""


class TruthDesk:
    """Serves the questions about a robot that change nothing."""

    def __init__(self, truth: Truth, module: Module) -> None:
        self._truth = truth
        module.serve(WhereReally, self._on_where)
        module.serve(WorldDoors, self._on_doors)
        module.serve(ReadBattery, self._on_battery)

    async def _on_where(self, _query: WhereReally, _context: Context) -> TrueLocation:
        return self._truth.true_location()

    async def _on_doors(self, _query: WorldDoors, _context: Context) -> list[DoorState]:
        return self._truth.door_states()

    async def _on_battery(self, _query: ReadBattery, _context: Context) -> BatteryState:
        return self._truth.battery_state()
