"""How a command of ``xavier`` asks the running modules."""

from __future__ import annotations

import os

from tca_bus import Module
from tca_bus.cli import BusFlags, bus_options


def client(flags: BusFlags) -> Module:
    """A module of this process alone, to ask with."""
    return Module(f"xavier-{os.getpid()}", options=bus_options(flags))
