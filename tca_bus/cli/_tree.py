"""``tca tree``: the task tree as it is, or as it changes."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Annotated

from cyclopts import Parameter

from tca_bus import Module, TaskStatus
from tca_bus._protocol import ListTasks
from tca_bus.cli._client import ask_central, joined
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, note, stdout_is_terminal

CLEAR = "\x1b[H\x1b[2J"
"""Moves a terminal to its top and clears it."""

_MARKS = {
    "inactive": "·",
    "pending": "○",
    "active": "●",
    "handled": "◐",
    "planned": "◑",
    "achieved": "✓",
    "failed": "✗",
    "killed": "⊘",
}


async def tree(
    id: str | None = None,
    /,
    *,
    watch: Annotated[bool, Parameter(negative="")] = False,
    alive: Annotated[bool, Parameter(negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Show the task tree: what runs, what it waits for, and what ended last.

    With --json a flat list of nodes, parents before their children; with --watch too, one
    object a line for each change.

    Parameters
    ----------
    id
        Only this task and what is below it, also when it ended long ago.
    watch
        Show it again with each change, until interrupted.
    alive
        Leave out top-level tasks that have ended.
    """
    async with joined(flags) as module:
        if watch and flags.json:
            await _stream(module, id)
        elif watch:
            await _redraw(module, id, alive=alive)
        else:
            _show(await _read(module, id, alive=alive), flags)


async def _read(module: Module, id: str | None, *, alive: bool) -> list[TaskStatus]:

    return await ask_central(module, ListTasks(id=id, ended=not alive))


def _show(statuses: Sequence[TaskStatus], flags: BusFlags) -> None:
    if flags.json:
        emit_json(list(statuses))
    elif not statuses:
        note("no task is under way")
    else:
        for line in tree_lines(statuses, time.time()):
            emit(line)


async def _redraw(module: Module, id: str | None, *, alive: bool) -> None:
    async with module.watch_statuses() as changes:
        while True:
            statuses = await _read(module, id, alive=alive)
            lines = list(tree_lines(statuses, time.time())) or ["no task is under way"]
            emit((CLEAR if stdout_is_terminal() else "") + "\n".join(lines))
            await anext(changes)


async def _stream(module: Module, id: str | None) -> None:
    async with module.watch_statuses() as changes:
        wanted = set[str]()
        for status in await _read(module, id, alive=True):
            wanted.add(status.id)
            emit_json(status, line=True)
        async for status in changes:
            if id is None or status.id in wanted or status.parent in wanted:
                wanted.add(status.id)
                emit_json(status, line=True)


def tree_lines(statuses: Sequence[TaskStatus], now: float) -> Iterator[str]:
    """Draw nodes as a tree, one line each; ``now`` is in seconds since the epoch."""
    below: dict[str | None, list[TaskStatus]] = defaultdict(list)
    shown = {status.id for status in statuses}
    for status in statuses:
        below[status.parent if status.parent in shown else None].append(status)
    stack = [(status, "", "") for status in reversed(below[None])]
    while stack:
        status, lead, rest = stack.pop()
        yield lead + _line(status, now)
        children = below[status.id]
        for number, child in enumerate(reversed(children)):
            corner, bar = ("└─ ", "   ") if number == 0 else ("├─ ", "│  ")
            stack.append((child, rest + corner, rest + bar))


def _line(status: TaskStatus, now: float) -> str:
    seconds = (status.ended or now) - status.created
    parts = [f"{_MARKS[status.state]} {status.name} {status.id}  {status.state}"]
    parts.append(f"{seconds:.1f} s")
    if status.handler:
        parts.append(status.handler + (f" (try {status.attempt})" if status.attempt > 1 else ""))
    if status.waiting_for:
        parts.append(f"waits for {status.waiting_for}")
    if status.failure:
        killed = status.state == "killed"
        parts.append(status.failure.text if killed else status.failure.sentence())
    return "  ".join(parts)
