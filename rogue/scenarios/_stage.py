"""An office of its own for a scenario: all processes, in lockstep, on a free port."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TextIO

from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions, Module
from tca_bus.launcher import Launcher, free_port


@dataclass(frozen=True, slots=True)
class Stage:
    """A running office, and a module that plays in it."""

    launcher: Launcher
    module: Module


@asynccontextmanager
async def stage(
    options: OfficeOptions, *, realm: str, console: TextIO | None = None
) -> AsyncIterator[Stage]:
    """Run an office on the loopback for as long as the block lasts.

    Args:
        options: what kind of office; its ``data`` also gets the logs.
        realm: of its messages.
        console: where the logs go besides.

    Raises:
        TcaError: a process does not start.
    """
    bus = BusOptions(connect=f"tcp/127.0.0.1:{free_port()}", realm=realm, clock="sim")
    specs = office_specs(options, bus)
    async with (
        Launcher(specs, bus, console=console, log_dir=options.data / "logs") as launcher,
        Module(f"rogue-{os.getpid()}", options=bus) as module,
    ):
        yield Stage(launcher, module)
