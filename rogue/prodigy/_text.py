"""Reading of text files, within bounds."""

from __future__ import annotations

from pathlib import Path

from rogue.prodigy._errors import PdlError, Position

MOST_BYTES = 50_000_000
"""Largest file that is read."""


def read_text(path: str | Path) -> str:
    """Return the text of a file.

    Raises:
        PdlError: If it is not UTF-8, with line and column, or larger than ``MOST_BYTES``.
        OSError: If it cannot be read.
    """
    with Path(path).open("rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        expected = f"a file of at most {MOST_BYTES // 1_000_000} MB"
        raise PdlError(Position(str(path), 1, 1), "a larger file", expected)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        column = error.start - before.rfind(b"\n")
        position = Position(str(path), before.count(b"\n") + 1, column)
        raise PdlError(position, f"byte {data[error.start]:#04x}", "text in UTF-8") from None
