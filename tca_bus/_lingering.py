"""TCP links that close at once.

Zenoh gives every TCP socket an ``SO_LINGER`` of ten seconds, which none of its settings changes: to
close one whose packets are lost then holds up the thread that does it until they pass again. That
is one of the few that read all links of the process, and often the one that waits for the kernel to
say which of them has something to read, so that everybody else's are not read either.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import struct
from pathlib import Path

OWN_FILES = Path("/dev/fd")
"""The folder of the open files of a process, on Linux and macOS."""

AS_ZENOH_SETS_IT = struct.pack("ii", 1, 10)
IN_THE_BACKGROUND = struct.pack("ii", 0, 0)
"""Closing returns at once, and the kernel goes on to send what is left."""

TOGETHER = 0.05
"""Wall seconds within which new links are dealt with together: a crowd may join a router."""


class PromptClosing:
    """Lets Zenoh's links close without waiting, now and those that are opened later."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        close_in_the_background()

    def link_opened(self) -> None:
        """See to a new link, and to others that are opened with it; called on the loop."""
        if self._timer is None:
            self._timer = self._loop.call_later(TOGETHER, self._rang)

    def end(self) -> None:
        """Stop the timer."""
        if self._timer is not None:
            self._timer.cancel()

    def _rang(self) -> None:
        self._timer = None
        close_in_the_background()


def close_in_the_background() -> None:
    """Have the kernel, not who closes them, wait for what Zenoh's sockets have still to send."""
    with contextlib.suppress(FileNotFoundError):
        for file in OWN_FILES.iterdir():
            _end_lingering(int(file.name))


def _end_lingering(file: int) -> None:
    # Any of them may be closed meanwhile, and most are no sockets.
    with contextlib.suppress(OSError):
        borrowed = socket.socket(fileno=file)
        try:
            size = len(AS_ZENOH_SETS_IT)
            if borrowed.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, size) == AS_ZENOH_SETS_IT:
                borrowed.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, IN_THE_BACKGROUND)
        finally:
            borrowed.detach()
