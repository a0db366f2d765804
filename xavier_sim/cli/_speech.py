"""``xavier speech``: the speech board, the keyboard, and who answers."""

from __future__ import annotations

import os
import sys
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus import configure_logging
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options
from xavier_sim.cli._flags import Data, checked_seed
from xavier_sim.office import Habits, Keyboard, RecordFile, SimulatedPeople, SpeechModule, Typist

Share = Annotated[float, Parameter(validator=Number(gte=0.0, lte=1.0))]


async def speech(
    *,
    people: Literal["auto", "keyboard"] = "auto",
    seed: int = 0,
    silence: Share = 0.05,
    silent_people: Annotated[Share, Parameter(env_var="XAVIER_SILENT_PEOPLE")] = 0.0,
    away: Annotated[Share, Parameter(env_var="XAVIER_AWAY")] = 0.0,
    missing_items: Annotated[Share, Parameter(env_var="XAVIER_MISSING_ITEMS")] = 0.0,
    data: Data = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the speech board and the keyboard until they are stopped.

    Args:
        people: Who answers: simulated people, or whoever sits at this terminal.
        seed: Seed of what the simulated people do, 0 or more.
        silence: Share of questions that the simulated people leave unanswered, 0 to 1.
        silent_people: Share of the people who never answer a robot.
        away: Share of the time that somebody is out of their room.
        missing_items: Share of the items that are not where they are to be picked up.
        data: Folder to keep what was said in, so that a restarted one does nothing twice.
        flags: Where the bus is.
    """
    configure_logging("speech", level=flags.level, json=flags.json)
    module = SpeechModule(bus_options(flags), RecordFile(data))
    if people == "auto":
        habits = Habits(
            silence=silence, silent_people=silent_people, away=away, missing_items=missing_items
        )
        await module.run(SimulatedPeople(module, seed=checked_seed(seed), habits=habits))
        return
    # A file of its own: the interpreter cannot end while a thread holds the lock of sys.stdin.
    async with Keyboard(os.fdopen(os.dup(0), errors="replace"), sys.stdout) as keyboard:
        await module.run(Typist(module.module, keyboard))
