"""``navigate where --watch``: the picture again and again, as the robot goes on."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass, replace
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


@dataclass(frozen=True, slots=True)
class Shot:
    """How things stood ``age`` wall seconds ago; ``why`` there is no later one, if so."""

    scene: Scene
    age: float = 0.0
    why: str = ""

    def words(self) -> str:
        """How old it is, and why."""
        return f"no answer, the picture is {self.age:.0f} s old: {self.why}"


async def watch_robot(module: Module, svg: Path | None, *, json: bool) -> None:
    """Show the robot until cancelled: in the terminal, or in the file ``svg``.

    While nobody answers, the terminal says so above the last picture; otherwise it is said once.

    Raises:
        ConfigError: the file cannot be written.
        NoHandlerError: there is no navigator to begin with.
    """
    if svg is None and not json and stdout_is_terminal():
        await _on_terminal(module)
        return
    if svg is not None:
        note(f"drawing into {svg}")
    is_away = False
    async for shot in _shots(module):
        if bool(shot.why) is not is_away:
            is_away = not is_away
            note(shot.words() if is_away else "there are answers again")
        if not is_away:
            _show(shot.scene, svg, json=json)


def _show(scene: Scene, svg: Path | None, *, json: bool) -> None:
    if svg is not None:
        write(scene, svg)
    if json:
        emit_json(scene.outlook, line=True)
    elif svg is None:
        emit(_picture(scene, 100, 40) + "\n")


async def _on_terminal(module: Module) -> None:
    console = Console()
    with Live(console=console, screen=True, auto_refresh=False) as live:
        async for shot in _shots(module):
            columns, rows = max(NARROWEST, console.width), max(LOWEST, console.height)
            live.update(Text(_framed(shot, columns, rows)), refresh=True)


def _framed(shot: Shot, columns: int, rows: int) -> str:
    """The picture, under a line about its age if it is old."""
    if not shot.why:
        return _picture(shot.scene, columns, rows)
    picture = _picture(shot.scene, columns, max(LOWEST, rows - 1))
    return f"{shot.words()[:columns]}\n{picture}"


def _picture(scene: Scene, columns: int, rows: int) -> str:
    return draw_text(scene.outlook, scene.plan, scene.world, columns=columns, rows=rows)


async def _shots(module: Module) -> AsyncIterator[Shot]:
    """How things stand, each time that there is news; while nobody answers, how they stood."""
    async with module.subscribe(Belief, size=1) as news:
        shot, at = Shot(await look(module)), time.monotonic()
        while True:
            yield shot
            await _news(news)
            try:
                shot, at = Shot(await look(module, shot.scene.plan)), time.monotonic()
            except AWAY as error:
                shot = replace(shot, age=time.monotonic() - at, why=str(error))


async def _news(news: Subscription[Belief]) -> None:
    await asyncio.sleep(LEAST)
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(PERIOD):
            await anext(news, None)
