"""Keys from a terminal while something is on the screen."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

KEYS = {
    b"\x1b[A": "up",
    b"\x1bOA": "up",
    b"k": "up",
    b"\x1b[B": "down",
    b"\x1bOB": "down",
    b"j": "down",
    b"\x1b[5~": "page up",
    b"b": "page up",
    b"\x1b[6~": "page down",
    b" ": "page down",
    b"\x1b[H": "home",
    b"\x1b[1~": "home",
    b"\x1bOH": "home",
    b"g": "home",
    b"\x1b[F": "end",
    b"\x1b[4~": "end",
    b"\x1bOF": "end",
    b"G": "end",
    b"f": "f",
    b"q": "quit",
}
"""What a terminal sends, and those of ``less``."""


def keys_of(data: bytes) -> Iterator[str]:
    """The keys in what a terminal sent; what is no key of ours is skipped."""
    while data:
        code = next((code for code in KEYS if data.startswith(code)), data[:1])
        if code in KEYS:
            yield KEYS[code]
        data = data[len(code) :]


@contextmanager
def keyboard(press: Callable[[str], None]) -> Iterator[None]:
    """Call ``press`` with each key; does nothing where standard input is no terminal.

    Ctrl-C stays a signal. The terminal is as it was when the block ends.
    """
    if not sys.stdin.isatty() or sys.platform == "win32":
        yield
        return
    import termios  # noqa: PLC0415 - absent on Windows
    import tty  # noqa: PLC0415 - same

    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)
    loop = asyncio.get_running_loop()

    def read() -> None:
        data = os.read(terminal, 1024)
        if not data:
            loop.remove_reader(terminal)
        for key in keys_of(data):
            press(key)

    try:
        tty.setcbreak(terminal)
        loop.add_reader(terminal, read)
        yield
    finally:
        loop.remove_reader(terminal)
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)
