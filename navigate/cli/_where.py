"""``navigate where``: where the robot believes to be, as a line, a drawing, or a live picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from navigate.cli._naming import client_name
from navigate.messages import WhereAmI
from navigate.wording import in_words
from tca_bus import Module
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options, emit, emit_json


async def where(
    *,
    svg: Path | None = None,
    watch: Annotated[bool, Parameter(name=["--watch", "-w"], negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Show where the robot believes to be.

    Args:
        svg: Draw it into this file: the floor, belief, way, goal and sonar, and beside it how
            things really stand, where a simulator tells that.
        watch: Go on, and show it again as it changes, until stopped: as a picture in the
            terminal, or in the file. With --json all of the outlook, one object a line.
        flags: Shared flags.
    """
    async with Module(client_name(), options=bus_options(flags)) as module:
        if watch:
            from navigate.cli._watching import watch_robot  # noqa: PLC0415 - numpy, rich

            await watch_robot(module, svg, json=flags.json)
            return
        if svg is not None:
            from navigate.cli._drawing import draw_once  # noqa: PLC0415 - numpy

            await draw_once(module, svg)
            return
        position = await module.query(WhereAmI())
    if flags.json:
        emit_json(position)
    else:
        emit(in_words(position))
