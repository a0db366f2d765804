"""The SQLite file behind the store: opening, migrating, and one transaction at a time."""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from importlib import resources
from pathlib import Path
from typing import Any, Self

import aiosqlite

from rogue.errors import StoreError

Row = tuple[Any, ...]

Rider = Callable[[aiosqlite.Connection], Awaitable[None]]
"""Writes what has waited for a commit, into the transaction that is about to be committed."""


class Database:
    """An SQLite file in WAL mode, an async context manager.

    Committed means on disk: the file survives a loss of power. One transaction runs at a time;
    reads outside of one see what is committed. What can wait is written by ``rider``, together
    with whatever is committed next.
    """

    def __init__(self, path: Path, rider: Rider | None = None) -> None:
        self.path = path
        self._rider = rider
        self._lock = asyncio.Lock()
        self._link: aiosqlite.Connection | None = None

    async def __aenter__(self) -> Self:
        try:
            await asyncio.to_thread(self.path.parent.mkdir, parents=True, exist_ok=True)
            self._link = await aiosqlite.connect(self.path, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise StoreError(str(self.path), f"cannot be opened ({error})") from error
        try:
            await self._prepare()
        except BaseException as error:
            await self._link.close()
            if isinstance(error, sqlite3.Error):
                raise StoreError(str(self.path), f"is no store of requests ({error})") from error
            raise
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.link.close()

    @property
    def link(self) -> aiosqlite.Connection:
        """The open connection."""
        if self._link is None:
            raise StoreError(str(self.path), "is not open")
        return self._link

    async def rows(self, sql: str, *values: object) -> list[Row]:
        """All rows of a query."""
        return [tuple(row) for row in await self.link.execute_fetchall(sql, values)]

    async def row(self, sql: str, *values: object) -> Row | None:
        """The first row of a query, if there is one."""
        found = await self.rows(sql, *values)
        return found[0] if found else None

    @asynccontextmanager
    async def transaction(self) -> AsyncIterator[aiosqlite.Connection]:
        """All statements of the block, or none of them."""
        async with self._lock:
            try:
                await self.link.execute("BEGIN IMMEDIATE")
                yield self.link
                if self._rider is not None:
                    await self._rider(self.link)
            except BaseException:
                # A cancelled statement is carried out all the same, before this one.
                await asyncio.shield(self.link.rollback())
                raise
            await asyncio.shield(self.link.commit())

    async def _prepare(self) -> None:
        for pragma in ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=5000"):
            await self.link.execute(f"PRAGMA {pragma}")
        found = await self.row("PRAGMA user_version")
        version = int(found[0]) if found else 0
        migrations = _migrations()
        if version > len(migrations):
            raise StoreError(
                str(self.path),
                f"was written by a newer version (schema {version}, known up to {len(migrations)})",
            )
        for number, script in enumerate(migrations[version:], version + 1):
            await self.link.executescript(
                f"BEGIN IMMEDIATE;\n{script}\nPRAGMA user_version={number};\nCOMMIT;"
            )


def _migrations() -> list[str]:
    """The numbered SQL scripts, in order; number n brings the schema to version n."""
    folder = resources.files("rogue.memory") / "migrations"
    files = sorted(
        (file for file in folder.iterdir() if file.name.endswith(".sql")), key=lambda f: f.name
    )
    return [file.read_text(encoding="utf-8") for file in files]
