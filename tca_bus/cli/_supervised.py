"""An async command in an event loop of its own, which signals and the parent's end cancel."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Callable, Coroutine
from typing import Any

from tca_bus._errors import ConfigError

PARENT_FD = "TCA_PARENT_FD"
"""Environment variable with the number of a pipe that closes when the launcher is gone."""

INTERRUPTED = 6
"""Exit code of a command that was cancelled before it was done."""


def run_async(make: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
    """Run a command to its end; what it returned, or the exit code of what stopped it."""
    with asyncio.Runner(loop_factory=_loop_factory()) as runner:
        return runner.run(_Supervised(make).run())


def _loop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    try:
        import uvloop  # noqa: PLC0415 - absent on Windows
    except ImportError:
        return asyncio.new_event_loop
    return uvloop.new_event_loop


class _Supervised:
    """One async command, cancelled by signals and by the end of the parent process."""

    def __init__(self, make: Callable[[], Coroutine[Any, Any, Any]]) -> None:
        self._make = make
        self._code: int | None = None
        self._task: asyncio.Task[Any] | None = None

    async def run(self) -> Any:
        """Run the command; after a stop its own result counts, else the stop's exit code."""
        loop = asyncio.get_running_loop()
        self._task = loop.create_task(self._make(), name="command")
        loop.add_signal_handler(signal.SIGINT, self._interrupt)
        loop.add_signal_handler(signal.SIGTERM, self._stop, 0)
        parent = self._watch_parent(loop)
        try:
            return await self._task
        except asyncio.CancelledError:
            if self._code is None:
                raise
            return self._code
        finally:
            if parent is not None:
                loop.remove_reader(parent)

    def _interrupt(self) -> None:
        if self._code is not None:
            os._exit(INTERRUPTED)
        self._stop(INTERRUPTED)

    def _stop(self, code: int) -> None:
        if self._code is None and self._task is not None:
            self._code = code
            self._task.cancel()

    def _watch_parent(self, loop: asyncio.AbstractEventLoop) -> int | None:
        text = os.environ.pop(PARENT_FD, "")
        if not text.isdigit():
            return None
        parent = int(text)
        try:
            os.set_inheritable(parent, False)
            loop.add_reader(parent, self._parent_said, loop, parent)
        except OSError as error:
            expected = f"an inherited end of a pipe ({error.strerror})"
            raise ConfigError(PARENT_FD, text, expected) from None
        return parent

    def _parent_said(self, loop: asyncio.AbstractEventLoop, parent: int) -> None:
        if os.read(parent, 4096):
            return
        loop.remove_reader(parent)
        self._stop(0)
