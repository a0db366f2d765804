"""``navigate where --watch``: the picture again and again, as the robot goes on."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from pathlib import Path

from rich.console import Console
from rich.live import Live
from rich.text import Text

from navigate.cli._drawing import Scene, look, write
from navigate.messages import Belief
from navigate.view import draw_text
from tca_bus import (
    BusGoneError,
    Module,
    NoHandlerError,
    PeerLostError,
    Subscription,
    TimedOutError,
)
from tca_bus.cli import emit, emit_json, note, stdout_is_terminal

PERIOD = 1.0
"""Wall seconds after which the picture is drawn anew although nothing was told."""

LEAST = 0.1
"""Wall seconds between two pictures."""

NARROWEST, LOWEST = 40, 12
"""Characters: the smallest terminal that the picture fits."""

AWAY = (BusGoneError, NoHandlerError, PeerLostError, TimedOutError)


async def watch_robot(module: Module, svg: Path | None, *, json: bool) -> None:
    """Show the robot until cancelled: in the terminal, or in the file ``svg``.

    Raises:
        ConfigError: the file cannot be written.
        NoHandlerError: there is no navigator to begin with.
    """
    if svg is None and not json and stdout_is_terminal():
        await _on_terminal(module)
        return
    if svg is not None:
        note(f"drawing into {svg}")
    async for scene in _scenes(module):
        if svg is not None:
            write(scene, svg)
        if json:
            emit_json(scene.outlook, line=True)
        elif svg is None:
            emit(_picture(scene, 100, 40) + "\n")


async def _on_terminal(module: Module) -> None:
    console = Console()
    with Live(console=console, screen=True, auto_refresh=False) as live:
        async for scene in _scenes(module):
            columns = max(NARROWEST, console.width)
            live.update(Text(_picture(scene, columns, max(LOWEST, console.height))), refresh=True)


def _picture(scene: Scene, columns: int, rows: int) -> str:
    return draw_text(scene.outlook, scene.plan, scene.world, columns=columns, rows=rows)


async def _scenes(module: Module) -> AsyncIterator[Scene]:
    """How things stand, each time that there is news; rests while the navigator is away."""
    async with module.subscribe(Belief, size=1) as news:
        scene = await look(module)
        while True:
            yield scene
            await _news(news)
            with contextlib.suppress(*AWAY):
                scene = await look(module, scene.plan)


async def _news(news: Subscription[Belief]) -> None:
    await asyncio.sleep(LEAST)
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(PERIOD):
            await anext(news, None)
