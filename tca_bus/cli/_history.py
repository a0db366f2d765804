"""``tca log``: the task history, from central's journal."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from datetime import datetime
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus import Module
from tca_bus._protocol import FindTask, LogEntry, ReadLog
from tca_bus.cli._client import ask_central, joined
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json

POLL_PERIOD = 0.5
"""Wall seconds between two looks at the journal."""

PAGE = 1000


async def log(
    id: str | None = None,
    /,
    *,
    follow: Annotated[bool, Parameter(negative="")] = False,
    last: Annotated[int, Parameter(validator=Number(gte=0))] = 100,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Show what happened to tasks: sent, given to a module, done, failed, killed.

    With --json a list, or one object a line with --follow.

    Parameters
    ----------
    id
        Only this task; with a top-level task all below it too.
    follow
        Go on with what happens from now on, until interrupted.
    last
        How many lines of the past to show; 0 shows all.
    """
    async with joined(flags) as module:
        entries = await _read(module, -last, id) if last else await _read_all(module, id)
        if id is not None and not entries and not follow:
            await ask_central(module, FindTask(id=id))
        _show(entries, flags, as_lines=follow)
        if follow:
            await _follow(module, entries, id, flags)


async def _follow(
    module: Module, entries: Sequence[LogEntry], id: str | None, flags: BusFlags
) -> None:
    seen = entries[-1].number if entries else 0
    while True:
        await asyncio.sleep(POLL_PERIOD)
        new = await _read(module, seen, id)
        _show(new, flags, as_lines=True)
        seen = new[-1].number if new else seen


async def _read_all(module: Module, id: str | None) -> list[LogEntry]:
    entries: list[LogEntry] = []
    while page := await _read(module, entries[-1].number if entries else 0, id):
        entries += page
    return entries


async def _read(module: Module, after: int, id: str | None) -> list[LogEntry]:
    return await ask_central(module, ReadLog(after=after, most=PAGE, task=id))


def _show(entries: Sequence[LogEntry], flags: BusFlags, *, as_lines: bool) -> None:
    if flags.json and not as_lines:
        emit_json(list(entries))
        return
    for entry in entries:
        if flags.json:
            emit_json(entry, line=True)
        else:
            when = datetime.fromtimestamp(entry.time).astimezone().strftime("%H:%M:%S.%f")[:-3]
            what = f"{entry.name} {entry.task}".strip()
            emit(f"{when}  {entry.event:<15} {what}  {entry.text}".rstrip())
