"""The conversation of the robot, as it was and as it goes on."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from rogue.absence import ABSENT
from rogue.cli._client import ask, on_bus
from rogue.cli._waiting import POLL_SECONDS
from rogue.messages import ReadTrace, TraceLine
from tca_bus import Module, Subscription
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json

PAGE = 1000
"""Lines that are asked for at once."""

RULES_LEVEL, FIRING = 3, "    Firing "
"""The level of the planner's trace that has rules, and how a line on a rule begins."""


async def trace(
    *,
    follow: Annotated[bool, Parameter(name=["--follow", "-f"], negative="")] = False,
    after: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    since: str | None = None,
    level: Annotated[int, Parameter(validator=Number(gte=2, lte=3))] = 3,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Print the conversation, as Figure 6 of the paper shows it.

    Parameters
    ----------
    follow
        Go on with what comes, until stopped.
    after
        Begin after this line.
    since
        Begin with what was said then: ISO 8601, HH:MM, or so long ago as 30m or 1h.
    level
        3 for everything; 2 without the rules that decided, which are told only where the agent
        was started with --level 3.
    """
    async with on_bus(flags) as module:
        begin = followed if follow else _all
        async for line in begin(module, after, since):
            if level < RULES_LEVEL and line.text.startswith(FIRING):
                continue
            if flags.json:
                emit_json(line, line=True)
            else:
                emit(line.text)


async def followed(
    module: Module, after: int = 0, since: str | None = None
) -> AsyncIterator[TraceLine]:
    """All lines after ``after``, then those to come; none twice, none left out."""
    async with module.subscribe(TraceLine) as news:
        while True:
            lines = await _page(module, after, since)
            for line in lines:
                after = line.seq
                yield line
            if len(lines) < PAGE:
                await _news(news, after)


async def _all(module: Module, after: int, since: str | None) -> AsyncIterator[TraceLine]:
    while lines := await ask(module, ReadTrace(after=after, since=since, most=PAGE)):
        for line in lines:
            yield line
        after = lines[-1].seq


async def _page(module: Module, after: int, since: str | None) -> list[TraceLine]:
    """The next lines; none while the agent is away."""
    try:
        return await ask(module, ReadTrace(after=after, since=since, most=PAGE))
    except ABSENT:
        await asyncio.sleep(POLL_SECONDS / 4)
        return []


async def _news(news: Subscription[TraceLine], after: int) -> None:
    """Wait until a newer line was broadcast, or for a while: a broadcast may be missed."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(POLL_SECONDS):
            async for line in news:
                if line.seq > after:
                    return
