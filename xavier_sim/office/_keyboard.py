"""The keyboard on the robot: questions on the terminal, lines read without blocking the loop."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
from collections import deque
from typing import Self, TextIO

log = logging.getLogger(__name__)

TYPE_AHEAD = 100
"""Lines that are kept before somebody asks for them; the oldest are dropped."""

LONG_CHOICES = {"i": "i(mpossible)"}
SPELLED_OUT = {"y": "yes", "n": "no", "i": "impossible"}


def prompt_for(question: str, choices: tuple[str, ...]) -> str:
    """A question as the keyboard shows it: with its choices, unless they are in it already."""
    shown = "/".join(LONG_CHOICES.get(choice, choice) for choice in choices)
    hint = f" ({shown})" if shown and not question.rstrip().endswith(")") else ""
    return f"{question}{hint}: "


def accept(line: str, choices: tuple[str, ...]) -> str | None:
    """The answer in a line, None when it is none of the choices."""
    text = line.strip()
    if not choices:
        return text or None
    words = {choice.lower(): choice for choice in choices}
    words |= {word: choice for choice, word in SPELLED_OUT.items() if choice in choices}
    return words.get(text.lower())


class Keyboard:
    """Reads lines in a thread of its own, for inputs that the event loop cannot poll.

    An async context manager. ``dropped`` counts lines that were typed ahead in vain.
    """

    def __init__(self, source: TextIO, screen: TextIO) -> None:
        self.dropped = 0
        self._source, self._screen = source, screen
        self._lines: deque[str] = deque()
        self._ended = False
        self._bell = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        # A thread that hangs in a read cannot be joined: it is a daemon, ended with the process.
        threading.Thread(target=self._read, name="keyboard", daemon=True).start()
        return self

    async def __aexit__(self, *_: object) -> None:
        self._loop = None

    def show(self, text: str) -> None:
        """Write to the screen at once."""
        self._screen.write(text)
        self._screen.flush()

    async def ask(self, question: str, choices: tuple[str, ...]) -> str | None:
        """Show a question until somebody types an answer that counts; None when input ended."""
        prompt = prompt_for(question, choices)
        while True:
            self.show(prompt)
            line = await self._next_line()
            if line is None:
                return None
            answer = accept(line, choices)
            if answer is not None:
                return answer
            wanted = " or ".join(choices) if choices else "something"
            self.show(f"Please type {wanted}.\n")

    async def _next_line(self) -> str | None:
        while not self._lines:
            if self._ended:
                return None
            self._bell.clear()
            await self._bell.wait()
        return self._lines.popleft()

    def _read(self) -> None:
        try:
            for line in self._source:
                self._post(line)
        except (OSError, ValueError) as error:
            log.warning("the keyboard cannot be read any more: %s", error)
        finally:
            self._post(None)

    def _post(self, line: str | None) -> None:
        loop = self._loop
        if loop is not None:
            # The loop may close between the look and the call; then nobody wants the line.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._take, line)

    def _take(self, line: str | None) -> None:
        if line is None:
            self._ended = True
        else:
            self._lines.append(line)
            if len(self._lines) > TYPE_AHEAD:
                self._lines.popleft()
                self.dropped += 1
        self._bell.set()
