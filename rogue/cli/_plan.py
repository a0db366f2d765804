"""The command that shows the plan, as text or as a drawing."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rogue.absence import ABSENT
from rogue.cli._client import ask, on_bus
from rogue.cli._drawing import write_drawing
from rogue.cli._waiting import POLL_SECONDS
from rogue.messages import PlanView, ShowPlan, TraceLine
from rogue.prodigy import render_tree
from tca_bus import Module, Subscription
from tca_bus.cli import (
    DEFAULT_FLAGS,
    BusFlags,
    emit,
    emit_json,
    note,
    stdout_is_terminal,
)

SETTLED_SECONDS = 0.2
"""Wall seconds for which news are gathered before the plan is shown again."""

CLEAR = "\x1b[H\x1b[2J\x1b[3J"
"""What empties a terminal."""


async def plan(
    *,
    svg: Path | None = None,
    watch: Annotated[bool, Parameter(name=["--watch", "-w"], negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Show the plan that is being carried out, or the last one: goals, operators, steps.

    Parameters
    ----------
    svg
        Draw it into this file instead, as Figure 9 of the paper: goals in ovals, operators in
        boxes. A browser shows which rule chose an operator when the pointer rests on it.
    watch
        Go on, and show it again whenever it has changed, until stopped.
    """
    async with on_bus(flags) as module:
        if not watch:
            _show(await ask(module, ShowPlan()), svg, flags, watch=False)
            return
        async for view in _changes(module):
            _show(view, svg, flags, watch=True)


def _show(view: PlanView, svg: Path | None, flags: BusFlags, *, watch: bool) -> None:
    if svg is not None:
        write_drawing(svg, view.tree, title=_title(view))
    if flags.json:
        emit_json(view, line=watch)
    elif svg is None:
        emit(f"{CLEAR if watch and stdout_is_terminal() else ''}{_text(view)}")
        if watch and not stdout_is_terminal():
            emit("")
    elif not watch:
        note(f"{len(view.tree.nodes)} goals and operators are drawn in {svg}")


def _text(view: PlanView) -> str:
    if not view.tree.nodes:
        return "Nothing was planned since the agent started."
    watched = [f"  {m.watches}, for {', '.join(m.requests)}" for m in view.monitors]
    parts = [f"{_title(view)}:", render_tree(view.tree), *(["", "Watched:"] if watched else [])]
    return "\n".join([*parts, *watched])


def _title(view: PlanView) -> str:
    return "The plan" if view.planning else "The last plan"


async def _changes(module: Module) -> AsyncIterator[PlanView]:
    """The plan each time that it is another."""
    last: PlanView | None = None
    async with module.subscribe(TraceLine) as news:
        while True:
            with contextlib.suppress(*ABSENT):
                view = await ask(module, ShowPlan())
                if view != last:
                    last = view
                    yield view
            await _news(news)


async def _news(news: Subscription[TraceLine]) -> None:
    """Wait until something was said, or for a while, since a broadcast may be missed."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(POLL_SECONDS):
            async for _ in news:
                break
    await asyncio.sleep(SETTLED_SECONDS)
    while news.at_hand() is not None:
        pass
