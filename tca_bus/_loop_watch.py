"""Names what holds up a module's event loop, from a thread: the loop itself cannot."""

from __future__ import annotations

import asyncio
import logging
import sys
import threading
import time
import traceback
from types import FrameType
from weakref import WeakKeyDictionary

logger = logging.getLogger(__name__)

PERIOD = 0.5
"""Wall seconds between two turns that the loop should take, and between two looks at them."""

PATIENCE = 2.0
"""Wall seconds after which a loop that has not turned is reported."""

FRAMES = 4
"""Innermost frames of the stack that are shown."""


async def watch_loop(module: str) -> None:
    """Report, once each time, when the loop of ``module`` stands still, and where.

    Modules of one loop have one thread for that.
    """
    loop = asyncio.get_running_loop()
    watch = _watches.get(loop)
    if watch is None:
        watch = _watches[loop] = LoopWatch()
        thread = threading.Thread(target=watch.run, name=f"{module}.loop_watch", daemon=True)
        thread.start()
    watch.modules.append(module)
    try:
        while True:
            watch.turned()
            await asyncio.sleep(PERIOD)
    finally:
        watch.modules.remove(module)
        if not watch.modules:
            watch.stop.set()
            del _watches[loop]


class LoopWatch:
    """Looks from a thread whether the loop that made it still turns."""

    def __init__(self) -> None:
        self.stop = threading.Event()
        self.modules: list[str] = []
        self._loop_thread = threading.get_ident()
        self._last_turn = time.monotonic()

    def turned(self) -> None:
        """The loop turns; called on it."""
        self._last_turn = time.monotonic()

    def run(self) -> None:
        """Look until stopped."""
        reported = 0.0
        while not self._rest():
            last = self._last_turn
            still = time.monotonic() - last
            if still > PATIENCE and last != reported:
                reported = last
                self._report(still)

    def _rest(self) -> bool:
        """Wait for the next look; true when there is none."""
        while True:
            before = time.monotonic()
            if self.stop.wait(PERIOD):
                return True
            # One who was late himself, on a machine that slept, has nothing to say of others.
            if time.monotonic() - before < PATIENCE:
                return False

    def _report(self, seconds: float) -> None:
        frame = sys._current_frames().get(self._loop_thread)  # noqa: SLF001 - the only way
        logger.warning(
            "the event loop of module %s has stood still for %.1f s; nothing else of the module "
            "runs meanwhile. It is at:\n%s",
            *(_names(self.modules), seconds, _place(frame)),
        )


_watches: WeakKeyDictionary[asyncio.AbstractEventLoop, LoopWatch] = WeakKeyDictionary()


def _names(modules: list[str]) -> str:
    first, *others = [*modules, "?"][: len(modules) or 1]
    return f"{first!r} and {len(others)} more" if others else repr(first)


def _place(frame: FrameType | None) -> str:
    if frame is None:
        return "  an unknown place"
    summary = traceback.extract_stack(frame)[-FRAMES:]
    return "\n".join(f"  {one.filename}:{one.lineno} in {one.name}" for one in summary)
