"""The wheels between motors and floor: what they turn, and what of it moves the robot."""

from __future__ import annotations

from dataclasses import dataclass

from xavier_sim.body._base import Velocities, next_velocities
from xavier_sim.profile import BaseProfile


@dataclass
class Wheels:
    """Wheels that grip, or slip for as long as nobody mends them.

    ``slip`` is the share of what they turn that moves the robot nowhere, 0 to 1; a robot of which
    one wheel slips turns by ``veer`` radians for each metre that the wheels turn. The encoders
    notice neither.
    """

    base: BaseProfile
    slip: float = 0.0
    veer: float = 0.0

    def drive(self, now: Velocities, wanted: Velocities) -> Velocities:
        """How the robot moves in the next physics step, given how it moves now."""
        speed, turn_rate = next_velocities(self.base, self.turned(*now), wanted)
        return speed * (1.0 - self.slip), turn_rate + self.veer * speed

    def turned(self, ahead: float, turn: float) -> tuple[float, float]:
        """What the wheels turn while the robot moves so: metres and radians, or per second."""
        counted = ahead / (1.0 - self.slip)
        return counted, turn - self.veer * counted

    def snapshot(self) -> dict[str, float]:
        """Everything that `restore` needs."""
        return {"slip": self.slip, "veer": self.veer}

    def restore(self, state: dict[str, float]) -> None:
        """Go back to a snapshot."""
        self.slip, self.veer = state["slip"], state["veer"]
