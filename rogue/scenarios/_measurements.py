"""What a scenario came to, measured with the simulator's word for the truth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from navigate.messages import WhereIsRoom
from rogue.messages import TraceLine
from rogue.scenarios._papers import VERIFYING
from tca_bus import Module
from xavier_sim.messages import WhereReally


@dataclass(slots=True)
class Arrival:
    """The robot said to be at a room; how far it really was from the room's place, in metres."""

    room: str
    error: float


@dataclass(slots=True)
class Measurements:
    """What a scenario came to: simulated seconds, metres driven, error at each arrival."""

    begun: float = 0.0
    metres_before: float = 0.0
    seconds: float = 0.0
    metres: float = 0.0
    arrivals: list[Arrival] = field(default_factory=list)

    def line(self) -> str:
        """The last line of a demonstration."""
        errors = ", ".join(f"{one.error:.2f} m at {one.room}" for one in self.arrivals)
        return (
            f"Simulated {self.seconds:.1f} s, driven {self.metres:.1f} m, "
            f"position error {errors or 'not measured'}."
        )


class Observer:
    """Measures while the trace goes by, with the simulator's word for the truth."""

    def __init__(self, module: Module) -> None:
        self._module = module
        self.measured = Measurements()

    async def begin(self) -> None:
        """Note where it starts."""
        truth = await self._module.query(WhereReally())
        self.measured.begun, self.measured.metres_before = truth.time, truth.metres

    async def see(self, line: TraceLine) -> None:
        """Measure at each arrival: the robot stands while it asks."""
        if VERIFYING in line.text:
            room = line.text.rsplit(" ", 1)[-1].lower()
            truth = await self._module.query(WhereReally())
            place = await self._module.query(WhereIsRoom(room=room))
            error = math.hypot(truth.x - place.x / 100.0, truth.y - place.y / 100.0)
            self.measured.arrivals.append(Arrival(room, error))

    async def end(self) -> Measurements:
        """Note where it ends."""
        truth = await self._module.query(WhereReally())
        self.measured.seconds = truth.time - self.measured.begun
        self.measured.metres = truth.metres - self.measured.metres_before
        return self.measured
