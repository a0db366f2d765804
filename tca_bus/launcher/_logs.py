"""The output of processes: cut into lines, kept as a tail, shown with a prefix, written away."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TextIO

TAIL_LINES = 500
"""Lines of each process that are kept in memory."""

LONGEST_LINE = 16_384
"""Bytes after which a line without an end is cut."""

_COLOURS = (36, 33, 35, 32, 34, 96, 93, 95, 92, 94)


class LineCutter:
    """Cuts a byte stream into lines; pure. A line that is too long is cut where it is."""

    def __init__(self) -> None:
        self._rest = b""

    @property
    def pending(self) -> bool:
        """Whether a line has begun and not ended."""
        return bool(self._rest)

    def feed(self, data: bytes) -> list[str]:
        """Take bytes; return the lines that they complete, without line ends."""
        *whole, rest = (self._rest + data).split(b"\n")
        lines = [piece for line in whole for piece in _pieces(line)]
        while len(rest) > LONGEST_LINE:
            lines.append(rest[:LONGEST_LINE])
            rest = rest[LONGEST_LINE:]
        self._rest = rest
        return [_text(line) for line in lines]

    def finish(self) -> list[str]:
        """Return the line that has begun, if any, as it is."""
        rest, self._rest = self._rest, b""
        return [_text(rest)] if rest else []


def _pieces(line: bytes) -> Iterable[bytes]:
    yield line[:LONGEST_LINE]
    for start in range(LONGEST_LINE, len(line), LONGEST_LINE):
        yield line[start : start + LONGEST_LINE]


def _text(line: bytes) -> str:
    return line.rstrip(b"\r").decode("utf-8", errors="backslashreplace")


class Console:
    """Shows the lines of all processes on one stream, each behind its process's name.

    Names are aligned. Each has a colour of its own when the stream is a terminal and
    ``NO_COLOR`` is not set.
    """

    def __init__(
        self, stream: TextIO, names: Iterable[str], *, environ: Mapping[str, str] = os.environ
    ) -> None:
        self._stream = stream
        names = list(names)
        width = max((len(name) for name in names), default=0)
        coloured = stream.isatty() and not environ.get("NO_COLOR")
        self._prefixes = {
            name: _prefix(name.ljust(width), number if coloured else None)
            for number, name in enumerate(names)
        }

    def write(self, name: str, line: str) -> None:
        """Show one line of a process."""
        self._stream.write(f"{self._prefixes[name]}{line}\n")
        self._stream.flush()


def _prefix(padded: str, number: int | None) -> str:
    if number is None:
        return f"{padded} | "
    return f"\x1b[{_COLOURS[number % len(_COLOURS)]}m{padded} |\x1b[0m "


class LogFile:
    """The log file of one process; past ``limit`` bytes it moves to ``.1`` and begins anew."""

    def __init__(self, path: Path, *, limit: int = 10_000_000) -> None:
        self.path, self._limit = path, limit
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("a", encoding="utf-8")

    def write(self, line: str) -> None:
        """Append one line."""
        if self._file.tell() > self._limit:
            self._file.close()
            self.path.replace(self.path.with_suffix(self.path.suffix + ".1"))
            self._file = self.path.open("a", encoding="utf-8")
        self._file.write(line + "\n")
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class ProcessLog:
    """All that becomes of the lines of one process."""

    def __init__(self, name: str, console: Console | None, file: LogFile | None) -> None:
        self._name, self._console, self._file = name, console, file
        self._tail: deque[str] = deque(maxlen=TAIL_LINES)

    def write(self, line: str) -> None:
        """Take one line that the process wrote."""
        self._tail.append(line)
        self._show(line)

    def remark(self, text: str) -> None:
        """Say something about the process, where its lines are seen."""
        self._show(f"-- {text}")

    def tail(self, most: int = TAIL_LINES) -> list[str]:
        """Return the last lines that the process wrote, the newest last."""
        return list(self._tail)[-most:]

    def close(self) -> None:
        """Close the file, if there is one."""
        if self._file is not None:
            self._file.close()

    def _show(self, line: str) -> None:
        if self._console is not None:
            self._console.write(self._name, line)
        if self._file is not None:
            self._file.write(line)


LineTaker = Callable[[str], None]
"""Called with each line of a process."""
