"""Simulators beside each other: one file each."""

from __future__ import annotations

from simulators.base import Simulator
from simulators.irsim import IrSim, IrSimFurnished, IrSimLoop
from simulators.ng import Navground, NavgroundFurnished, NavgroundLoop
from simulators.ours import Ours, OursFiltered, OursFurnished, OursLoop

SIMULATORS: dict[str, type[Simulator]] = {
    "ours": Ours,
    "navground": Navground,
    "irsim": IrSim,
    "ours-furnished": OursFurnished,
    "navground-furnished": NavgroundFurnished,
    "irsim-furnished": IrSimFurnished,
    "ours-loop": OursLoop,
    "ours-filter": OursFiltered,
    "navground-loop": NavgroundLoop,
    "irsim-loop": IrSimLoop,
}

__all__ = ["SIMULATORS", "Simulator"]
