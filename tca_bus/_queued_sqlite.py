"""A SQLite connection that does what is queued for it together with its commit.

Each call of aiosqlite is a hop to the database's thread and back, which costs more than most
statements do. A transaction that is known beforehand needs one.
"""

from __future__ import annotations

import sqlite3
from collections import deque
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import aiosqlite

Statement = tuple[str, Sequence[tuple[Any, ...]]]
"""SQL, and the rows of values for which it is done."""

Queue = deque[Statement]
"""The statements of the next commit, in order; whoever fills it awaits the commit before more."""


class QueuedConnection(sqlite3.Connection):
    """As `sqlite3.Connection`; ``commit`` does the statements of ``queue`` first."""

    def __init__(self, *values: Any, queue: Queue, **options: Any) -> None:
        super().__init__(*values, **options)
        self._queue = queue

    def commit(self) -> None:
        """Do what is queued, and commit; when a statement fails the rest is given up."""
        statements = list(self._queue)
        self._queue.clear()
        for query, rows in statements:
            self.executemany(query, rows)
        super().commit()


async def connect(database: Path | str, queue: Queue) -> aiosqlite.Connection:
    """Open a database whose commits do what is in ``queue``."""
    return await aiosqlite.connect(database, factory=partial(QueuedConnection, queue=queue))
