"""``tca tree --watch``: the live tree on a terminal, or its changes line by line."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import sys
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from tca_bus import BusGoneError, Module, PeerLostError, Subscription, TaskStatus, TimedOutError
from tca_bus._protocol import ListTasks
from tca_bus.cli._client import NoCentralError, ask_central
from tca_bus.cli._forest import Forest
from tca_bus.cli._keyboard import keyboard
from tca_bus.cli._output import emit, emit_json
from tca_bus.cli._tree_rows import Line, TreeView, node_text

QUEUE = 65_536
"""States that wait to be taken in; should more come at once, everything is read again."""

LEAST_FRAME = 0.1
"""Wall seconds between two frames."""

DRAWING_SHARE = 0.25
"""Part of the time that may go into frames while states keep coming."""

TICK = 1.0
"""Wall seconds after which a frame is drawn though nothing changed: the times go on."""

READ_TIMEOUT = 60.0
"""Wall seconds in which central lists the tree."""

AWAY = (NoCentralError, BusGoneError, PeerLostError, TimedOutError)

STYLES = {
    "inactive": "dim",
    "pending": "cyan",
    "active": "bold green",
    "handled": "green",
    "planned": "green",
    "achieved": "dim",
    "failed": "bold red",
    "killed": "yellow",
}


@dataclass
class Feed:
    """Keeps a forest up to date; reads the whole tree first, and again after a loss only."""

    module: Module
    forest: Forest
    changes: Subscription[TaskStatus]
    ended: bool
    is_reading: bool = False
    _seen: object = None
    _touched: set[str] = field(default_factory=set)

    async def read(self) -> None:
        """Read the whole tree.

        Raises:
            NoCentralError: Central is not there.
            TaskError: It does not know the task.
        """
        self._seen = self._losses()
        self._touched.clear()
        question = ListTasks(id=self.forest.only, ended=self.ended)
        listed = await ask_central(self.module, question, timeout=READ_TIMEOUT)
        self.forest.replace(listed, keep=self._touched)

    async def wait(self, timeout: float) -> list[TaskStatus]:
        """What changed, as soon as something has; nothing after ``timeout`` wall seconds."""
        changed: list[TaskStatus] = []
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                changed += self._take(await self.changes.get())
        while self.changes.waiting:
            changed += self._take(await self.changes.get())
        self._read_after_loss()
        return changed

    def _take(self, status: TaskStatus) -> list[TaskStatus]:
        self._touched.add(status.id)
        return [status] if self.forest.take(status) else []

    def _read_after_loss(self) -> None:
        if self._losses() != self._seen and not self.is_reading:
            self.is_reading = True
            self.module.start(self._read_again(), name="tree.read")

    async def _read_again(self) -> None:
        # While central is away the losses stay as they are: the next look tries again.
        try:
            await self.read()
        except AWAY:
            self._seen = None
        finally:
            self.is_reading = False

    def _losses(self) -> tuple[int, int, str]:
        """What may have lost states; a central that was started again may know others."""
        centrals = [m.incarnation for m in self.module.modules() if m.name == "central"]
        return self.changes.dropped, self.module.outages, max(centrals, default="")


@asynccontextmanager
async def _feed(module: Module, id: str | None, *, alive: bool) -> AsyncIterator[Feed]:
    forest = Forest(only=id, most_ended=0) if alive else Forest(only=id)
    async with module.watch_statuses(size=QUEUE) as changes:
        feed = Feed(module, forest, changes, ended=not alive)
        await feed.read()
        yield feed


async def stream(module: Module, id: str | None, *, json: bool) -> None:
    """Print the nodes that are alive and then each change, a line each, until cancelled."""
    async with _feed(module, id, alive=True) as feed:
        for status in list(feed.forest.nodes.values()):
            _print(status, json=json)
        while True:
            for status in await feed.wait(TICK):
                _print(status, json=json)


def _print(status: TaskStatus, *, json: bool) -> None:
    if json:
        emit_json(status, line=True)
        return
    now = time.time()
    clock = time.strftime("%H:%M:%S", time.localtime(now))
    emit(f"{clock}.{int(now % 1 * 1000):03d}  {node_text(status, now)}")


async def watch(module: Module, id: str | None, *, alive: bool) -> None:
    """Show the tree on the whole terminal until ``q`` or an interrupt."""
    async with _feed(module, id, alive=alive) as feed:
        screen = Screen(TreeView(feed.forest, title=f"realm {module.options.realm}"))
        with screen.shown():
            await screen.run(feed)


class Screen:
    """Draws a view on the terminal and hands it the keys."""

    def __init__(self, view: TreeView) -> None:
        self._view = view
        self._console = Console(highlight=False, markup=False, emoji=False)
        self._live = Live(console=self._console, screen=True, auto_refresh=False)
        self._bell = asyncio.Event()
        self._quit = False
        self._pause = LEAST_FRAME

    @contextlib.contextmanager
    def shown(self) -> Iterator[None]:
        """Take the terminal, and give it back as it was."""
        with self._live, keyboard(self._press), _resizes(self._bell):
            yield

    async def run(self, feed: Feed) -> None:
        """Draw whenever something changed, not more often than a person can follow."""
        while not self._quit:
            self._view.note = _note(feed)
            begin = time.monotonic()
            self._draw()
            self._pause = max(LEAST_FRAME, (time.monotonic() - begin) / DRAWING_SHARE)
            self._bell.clear()
            await self._change(feed)

    async def _change(self, feed: Feed) -> None:
        """Wait for a key, for states, or for the next tick; states a frame long at least."""
        pressed = asyncio.ensure_future(self._bell.wait())
        came = asyncio.ensure_future(_gather_changes(feed, self._pause))
        try:
            await asyncio.wait({pressed, came}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            pressed.cancel()
            came.cancel()
            results = await asyncio.gather(pressed, came, return_exceptions=True)
        for result in results:
            if isinstance(result, Exception):
                raise result

    def _press(self, key: str) -> None:
        if key == "quit":
            self._quit = True
        else:
            self._view.press(key)
        self._bell.set()

    def _draw(self) -> None:
        lines = self._view.frame(time.time(), self._console.size.height)
        head, *rows, foot = map(_text, lines)
        head.stylize("reverse")
        foot.stylize("dim")
        self._live.update(Group(head, *rows, foot), refresh=True)


async def _gather_changes(feed: Feed, pause: float) -> None:
    if await feed.wait(TICK):
        await asyncio.sleep(pause)


def _note(feed: Feed) -> str:
    if not feed.module.is_connected:
        return "the router is away"
    return "states were lost: reading again" if feed.is_reading else ""


def _text(line: Line) -> Text:
    style = STYLES.get(line.state or "", "")
    return Text(line.text, style=style, no_wrap=True, overflow="ellipsis")


@contextlib.contextmanager
def _resizes(bell: asyncio.Event) -> Iterator[None]:
    if sys.platform == "win32":
        yield
        return
    loop = asyncio.get_running_loop()
    loop.add_signal_handler(signal.SIGWINCH, bell.set)
    try:
        yield
    finally:
        loop.remove_signal_handler(signal.SIGWINCH)
