"""The battery: drained by time and way, filled at the charger."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from xavier_sim.profile import BatteryProfile


@dataclass
class Battery:
    """How full it is, 0 to 1, and whether it is being charged."""

    profile: BatteryProfile
    charge: float = 1.0
    charging: bool = False

    def use(self, metres: float, seconds: float, *, at_charger: bool) -> None:
        """Drain it by what was driven and by the time that passed, or charge it."""
        self.charging = at_charger
        if at_charger:
            self.charge = min(1.0, self.charge + seconds / self.profile.charging_seconds)
            return
        drained = seconds / self.profile.standing_seconds + metres / self.profile.metres
        self.charge = max(0.0, self.charge - drained)

    @property
    def low(self) -> bool:
        """Whether the robot should make for its charger."""
        return self.charge <= self.profile.low

    @property
    def empty(self) -> bool:
        """Whether the wheels stand still for want of current."""
        return self.charge <= 0.0

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"charge": self.charge, "charging": self.charging}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.charge, self.charging = state["charge"], state["charging"]
