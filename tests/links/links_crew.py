"""The modules on both sides: ``python links_crew.py ROLE FOLDER``; they note what they do.

``FOLDER/deeds`` gets a JSON object a line, ``FOLDER/up`` is made by the test when lifts may end.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
import time
from pathlib import Path

from tca_bus import BusOptions, Command, Goal, KilledError, Module, TaskFailedError
from tca_bus.testing import eventually

PATIENCE = 60.0


class Lift(Command[str]):
    """Lift until ``FOLDER/up`` is there; lost with its module."""


class Relift(Command[str]):
    """The same, given to another module when this one is lost."""

    on_module_lost = "resend"


class Span(Goal[list[str]]):
    """A goal of the near side whose two commands are carried out on the far side."""

    again: bool


class Diary:
    """What happened, in a file."""

    def __init__(self, folder: Path, who: str) -> None:
        self._path = folder / "deeds"
        self._who = who

    def note(self, what: str, **facts: object) -> None:
        entry = {"who": self._who, "what": what, "time": time.monotonic(), **facts}
        with self._path.open("a") as file:
            file.write(json.dumps(entry) + "\n")


async def lift_until_up(folder, diary, context):
    diary.note("begun", task=context.id, attempt=context.attempt)
    try:
        await eventually((folder / "up").exists, timeout=PATIENCE)
    except asyncio.CancelledError:
        diary.note("stopped", task=context.id, attempt=context.attempt)
        raise
    diary.note("done", task=context.id, attempt=context.attempt)
    return diary._who


async def lifter(module, folder, diary):
    async def lift(message, context):
        return await lift_until_up(folder, diary, context)

    module.serve(Lift, lift)
    module.serve(Relift, lift)
    async with module:
        await watch(module, diary)


async def boss(module, folder, diary):
    @module.handler(Span)
    async def span(message, context):
        kind = Relift if message.again else Lift
        lifts = [await context.execute(kind(), wait_for_handler=PATIENCE) for _ in range(2)]
        return [await one.result() for one in lifts]

    async with module:
        await watch(module, diary)


async def watch(module, diary):
    async with module.watch_modules() as changes:
        async for change in changes:
            diary.note("appeared" if change.appeared else "lost", module=change.module.name)


async def chief(module, folder, diary, again):
    """Send one goal and say how it ended."""
    async with module:
        await module.wait_for(Span, Lift, Relift, "tca.submit", timeout=PATIENCE)
        handle = await module.expand(Span(again=again))
        diary.note("sent", task=handle.id)
        try:
            diary.note("ended", state="achieved", result=await handle.result())
        except (TaskFailedError, KilledError) as error:
            chain, failure = [], getattr(error, "failure", None)
            while failure is not None:
                chain.append(failure.name)
                failure = failure.cause
            diary.note("ended", state="failed", result=chain)


async def main(role: str, where: str, *more: str) -> None:
    folder = Path(where)
    here = os.environ["TCA_CONNECT"]
    options = BusOptions(connect=here, realm="links", connect_timeout=PATIENCE)
    module, diary = Module(role, options=options), Diary(folder, role)
    if role == "chief":
        await chief(module, folder, diary, *(word == "again" for word in more))
    elif role == "boss":
        await boss(module, folder, diary)
    else:
        await lifter(module, folder, diary)


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
