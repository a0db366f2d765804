"""Whether two stores tell of the same, to the tick: so two runs of one day are compared."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from rogue.errors import StoreError
from rogue.memory._database import Database, Row

TABLES = ("requests", "notes", "facts", "steps", "served", "holds", "decisions", "trace")
"""What tells of a run; the identity of a store is its own."""

TIMES = ("time", "started", "posted")
"""Columns that say when it was, seconds since the epoch."""

COUNTERS = {"notes": "number", "decisions": "number", "trace": "seq"}
"""Columns that only count rows: of what happens at one time, who is first is not fixed."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first thing that two stores do not both tell.

    ``time`` is when it was, seconds since the epoch, None for what has no time; ``one`` and
    ``other`` are what the stores tell in its place, None where they tell nothing more.
    """

    table: str
    time: float | None
    one: Row | None
    other: Row | None


@dataclass(frozen=True, slots=True)
class _Told:
    time: float
    row: Row

    @property
    def key(self) -> tuple[float, str]:
        return self.time, repr(self.row)


async def first_difference(one: Path, other: Path) -> Difference | None:
    """Compare two files of stores that nobody writes to; None when they tell the same.

    Raises:
        StoreError: one of them is missing or is no store.
    """
    for path in (one, other):
        if not path.exists():
            raise StoreError(str(path), "is not there")
    async with Database(one) as first, Database(other) as second:
        found = [await _first_in(table, first, second) for table in TABLES]
    return min(filter(None, found), key=_when, default=None)


async def _first_in(table: str, one: Database, other: Database) -> Difference | None:
    for mine, its in zip_longest(await _told(table, one), await _told(table, other)):
        if mine is None or its is None or mine.row != its.row:
            seen = [told for told in (mine, its) if told is not None]
            time = min(told.time for told in seen)
            return Difference(
                table,
                time if time < float("inf") else None,
                mine.row if mine else None,
                its.row if its else None,
            )
    return None


async def _told(table: str, base: Database) -> list[_Told]:
    """The rows of a table in the order of their times."""
    try:
        columns = [str(row[1]) for row in await base.rows(f"PRAGMA table_info({table})")]
        kept = [name for name in columns if name != COUNTERS.get(table)]
        names = ", ".join(f'"{name}"' for name in kept)
        rows = await base.rows(f"SELECT {names} FROM {table}")  # noqa: S608 - names of our own
    except sqlite3.Error as error:
        raise StoreError(str(base.path), f"cannot be read ({error})") from error
    at = next((kept.index(name) for name in TIMES if name in kept), None)
    return sorted(_timed(rows, at), key=lambda told: told.key)


def _timed(rows: Iterable[Row], at: int | None) -> list[_Told]:
    return [_Told(float("inf") if at is None else row[at], row) for row in rows]


def _when(difference: Difference) -> float:
    return float("inf") if difference.time is None else difference.time
