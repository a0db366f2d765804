"""``tca tree``: the task tree as it is, or as it changes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Annotated

from cyclopts import Parameter

from tca_bus import TaskStatus
from tca_bus._protocol import ListTasks
from tca_bus.cli._client import ask_central, joined
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, note, stdout_is_terminal
from tca_bus.cli._tree_rows import tree_lines


async def tree(
    id: str | None = None,
    /,
    *,
    watch: Annotated[bool, Parameter(name=["--watch", "-w"], negative="")] = False,
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
        Show it live until q or Ctrl-C; long runs of siblings are folded into a count, f
        unfolds them. Where standard output is no terminal, print a line for each change.
    alive
        Leave out top-level tasks that have ended.
    """
    async with joined(flags) as module:
        if watch:
            from tca_bus.cli import _tree_watch  # noqa: PLC0415 - others do not pay for rich

            if flags.json or not stdout_is_terminal():
                await _tree_watch.stream(module, id, json=flags.json)
            else:
                await _tree_watch.watch(module, id, alive=alive)
        else:
            statuses = await ask_central(module, ListTasks(id=id, ended=not alive))
            _show(statuses, flags)


def _show(statuses: Sequence[TaskStatus], flags: BusFlags) -> None:
    if flags.json:
        emit_json(list(statuses))
    elif not statuses:
        note("no task is under way")
    else:
        for line in tree_lines(statuses, time.time()):
            emit(line)
