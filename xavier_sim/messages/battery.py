"""The battery and the charger."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Broadcast, Query
from xavier_sim.messages.floorplan import Corner


class BatteryState(BaseModel):
    """How full the battery is, 0 to 1.

    ``low`` says that the robot should make for its charger, which is at ``charger`` in metres
    (None on a floor without one); ``charging`` that it stands there. An empty robot stands still.
    One that needs no charging is always full. ``time`` is simulated seconds since the epoch.
    """

    model_config = ConfigDict(frozen=True)

    charge: float = Field(ge=0.0, le=1.0)
    low: bool
    charging: bool
    charger: Corner | None
    time: float


class ReadBattery(Query[BatteryState]):
    """Ask how full the battery is."""

    wire_name = "xavierCharge"


class Battery(Broadcast):
    """The battery has come to another hundredth, or charging has begun or ended."""

    wire_name = "xavierBattery"

    state: BatteryState
