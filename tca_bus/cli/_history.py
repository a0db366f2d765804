"""``tca log``: the task history, from central's journal."""

from __future__ import annotations

import asyncio
import contextlib
from collections import defaultdict
from collections.abc import AsyncIterator, Iterable, Iterator
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus import Module, Subscription, TaskStatus
from tca_bus._log_grammar import Letters, data_line, lines_of
from tca_bus._protocol import FindTask, LogEntry, ReadLog
from tca_bus.cli._client import ask_central, joined
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json

QUIET_PERIOD = 1.0
"""Wall seconds without a task state after which the journal is looked at all the same."""

LEAST_PERIOD = 0.05
"""Wall seconds between two looks at the journal."""

PAGE = 1000

DEFAULT_LETTERS = "mstdrp"

BEGINNINGS = frozenset({"dispatched", "started"})
ENDINGS = frozenset({"handled", "handler failed", "handler stopped"})


async def log(
    id: str | None = None,
    /,
    *,
    follow: Annotated[bool, Parameter(name=["--follow", "-f"], negative="")] = False,
    last: Annotated[int, Parameter(validator=Number(gte=0))] = 100,
    letters: Annotated[str, Parameter(name=["--letters", "-l"])] = DEFAULT_LETTERS,
    message: Annotated[tuple[str, ...], Parameter(name=["--message", "-m"], negative="")] = (),
    ignore: Annotated[tuple[str, ...], Parameter(name=["--ignore", "-i"], negative="")] = (),
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Show what happened to tasks, in the grammar of TCA's own log.

    With --json one object a line.

    Parameters
    ----------
    id
        Only this task; with a top-level task all below it too.
    follow
        Go on with what happens from now on, until interrupted.
    last
        How many entries of the past to show; 0 shows all.
    letters
        What to show, as central's -l in TCA: m messages, s answers and kills, t time, d data,
        h time spent in handlers, r numbers of nodes, p of their parents, n no remarks.
    message
        Only tasks of this message; may be given more than once.
    ignore
        Leave out tasks of this message; may be given more than once.
    """
    shown = _Shown(Letters.parse(letters), flags)
    question = ReadLog(most=PAGE, task=id, messages=message, ignore=ignore)
    async with joined(flags) as module, contextlib.AsyncExitStack() as stack:
        changes = await stack.enter_async_context(module.watch_statuses()) if follow else None
        past = [entry async for entry in _past(module, question, last)]
        if id is not None and not past and not follow:
            await ask_central(module, FindTask(id=id))
        shown.show(past)
        if changes is not None:
            seen = past[-1].number if past else 0
            async for entries in _new(module, question, seen, changes):
                shown.show(entries)
        shown.end(past)


async def _past(module: Module, question: ReadLog, last: int) -> AsyncIterator[LogEntry]:
    """The last entries in pages, or all of them when ``last`` is 0."""
    after, left = -last, last or None
    while left is None or left > 0:
        page = await _read(module, question, after)
        for entry in page[:left]:
            yield entry
        if len(page) < PAGE:
            return
        after = page[-1].number
        left = None if left is None else left - len(page)


async def _new(
    module: Module, question: ReadLog, seen: int, changes: Subscription[TaskStatus]
) -> AsyncIterator[list[LogEntry]]:
    """What is added to the journal, as task states tell that something was."""
    while True:
        page = await _read(module, question, seen)
        if page:
            seen = page[-1].number
            yield page
        if len(page) < PAGE:
            await _wait(changes)


async def _wait(changes: Subscription[TaskStatus]) -> None:
    await asyncio.sleep(LEAST_PERIOD)
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(QUIET_PERIOD):
            await changes.get()
    while changes.waiting:
        await changes.get()


async def _read(module: Module, question: ReadLog, after: int) -> list[LogEntry]:
    return await ask_central(module, question.model_copy(update={"after": after}))


class _Shown:
    """Prints entries as the user wants them."""

    def __init__(self, letters: Letters, flags: BusFlags) -> None:
        self._letters = letters
        self._json = flags.json

    def show(self, entries: Iterable[LogEntry]) -> None:
        for entry in entries:
            if self._json:
                emit_json(entry.model_dump(mode="json", exclude={"statements"}), line=True)
                continue
            for line in entry_lines(entry, self._letters):
                emit(line)

    def end(self, entries: Iterable[LogEntry]) -> None:
        if "h" in self._letters and not self._json:
            for line in summary_lines(entries):
                emit(line)


def entry_lines(entry: LogEntry, letters: Letters) -> Iterator[str]:
    """The lines of TCA's log for an entry."""
    for number, statement in enumerate(entry.statements):
        yield from lines_of(statement, entry.time, letters)
        if number == 0 and entry.data is not None and "d" in letters:
            yield data_line(entry.task, entry.data)


def summary_lines(entries: Iterable[LogEntry]) -> Iterator[str]:
    """How often each message was handled in these entries, and for how long, in seconds."""
    begun: dict[str, float] = {}
    spent: dict[str, list[float]] = defaultdict(list)
    for entry in entries:
        if entry.event in BEGINNINGS:
            begun[entry.task] = entry.time
        elif entry.event in ENDINGS and entry.task in begun:
            spent[entry.name].append(entry.time - begun.pop(entry.task))
    for name, times in sorted(spent.items()):
        mean, most = sum(times) / len(times), max(times)
        yield f"    {name}: handled {len(times)} times, mean {mean:.2f} s, longest {most:.2f} s"
