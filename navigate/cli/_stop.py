"""``navigate stop``: stand still, now."""

from __future__ import annotations

from navigate.cli._naming import client_name
from navigate.messages import StopDriving
from navigate.wording import in_words
from tca_bus import Module
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options, emit, emit_json


async def stop(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Stop the robot now. The drive under way fails with "cancelled".

    Goes straight to the navigator, past central and the task tree. Whoever sent the robot may send
    it again: to keep it still, kill their task with 'tca kill', or end their program.

    Args:
        flags: Shared flags.
    """
    async with Module(client_name(), options=bus_options(flags)) as module:
        position = await module.query(StopDriving())
    if flags.json:
        emit_json(position)
    else:
        sure = position.heard and not position.lost
        emit(f"stopped{' at' if sure else ';'} {in_words(position)}")
