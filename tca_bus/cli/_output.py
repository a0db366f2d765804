"""What commands print: tables for people, JSON for scripts, notes on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from typing import Any


def emit(text: str) -> None:
    """Print one line on standard output."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def emit_json(value: Any, *, line: bool = False) -> None:
    """Print a JSON document, or one object a line for a stream.

    Args:
        value: A JSON value, a pydantic model, or a list of models.
        line: Whether it is one of a stream: no indentation then.
    """
    emit(json.dumps(_plain(value), indent=None if line else 2, ensure_ascii=False))


def note(text: str) -> None:
    """Say something to a person on standard error."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def show_table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table; without a terminal it is as wide as its content needs."""
    from rich.console import Console  # noqa: PLC0415 - JSON output does not pay for it
    from rich.table import Table  # noqa: PLC0415 - same

    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*("" if cell is None else str(cell) for cell in row))
    width = None if stdout_is_terminal() else 10_000
    Console(width=width, markup=False, highlight=False, emoji=False).print(table)


def stdout_is_terminal() -> bool:
    """Whether a person reads standard output directly."""
    return sys.stdout.isatty()


def _plain(value: Any) -> Any:
    if hasattr(value, "model_dump"):
        return value.model_dump(mode="json")
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
