"""Lines that a person types in answer to questions."""

from __future__ import annotations

import asyncio
import os
from dataclasses import dataclass

CHUNK = 4096


@dataclass
class TypedLines:
    """The lines of a terminal or pipe, without a thread that would outlast the question.

    A question that is cancelled takes nothing of what is typed later.
    """

    file: int
    _rest: bytes = b""

    async def next(self) -> str | None:
        """The next line without its end; None when there is none any more."""
        while b"\n" not in self._rest:
            more = await self._read()
            if not more:
                last, self._rest = self._rest, b""
                return last.decode(errors="replace") or None
            self._rest += more
        line, _, self._rest = self._rest.partition(b"\n")
        return line.decode(errors="replace")

    async def _read(self) -> bytes:
        loop = asyncio.get_running_loop()
        there_is_more = asyncio.Event()
        try:
            loop.add_reader(self.file, there_is_more.set)
        except OSError:
            # A plain file, which never makes one wait.
            return os.read(self.file, CHUNK)
        try:
            await there_is_more.wait()
        finally:
            loop.remove_reader(self.file)
        return os.read(self.file, CHUNK)
