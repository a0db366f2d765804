"""The append-only journal of the task tree, in SQLite.

Written in transactions of whatever came together; a task is acknowledged after its commit. In
WAL mode with full synchronisation a commit survives the end of the process and of the power.
"""

from __future__ import annotations

import asyncio
import contextlib
import sqlite3
import time
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Sequence
from importlib import resources
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

import aiosqlite

from tca_bus._errors import ConfigError, TcaError
from tca_bus._log_reader import END, LogReader
from tca_bus._protocol import LogEntry, ReadLog, TaskStatus
from tca_bus._queued_sqlite import Queue, connect
from tca_bus.resources import (
    KINDS,
    Changes,
    Finished,
    ResourceEvent,
    decode_resource_event,
    encode_resource_event,
)
from tca_bus.tasktree import (
    TOMBSTONE_SECONDS,
    Ended,
    Freed,
    Prepared,
    Record,
    RecordedEvent,
    Registered,
    Submitted,
    decode_event,
    encode_event,
)

T = TypeVar("T")

APPLICATION_ID = 0x54434131
"""Marks the file as ours ("TCA1"), so that another program's database is not taken for one."""

BEGINNINGS = (Submitted, Prepared, Registered)
"""Events with which the records of a root begin."""

INSERT_EVENT = "INSERT INTO events (time, root, task, name, kind, body) VALUES (?, ?, ?, ?, ?, ?)"

BEGIN_ROOT = (
    "INSERT INTO roots (root) VALUES (?1) ON CONFLICT DO UPDATE "
    "SET ended = CASE WHEN ?2 THEN NULL ELSE ended END"
)
END_ROOT = "UPDATE roots SET ended = ? WHERE root = ?"
FORGET_ROOTS = "DELETE FROM roots WHERE ended IS NOT NULL AND root NOT IN (SELECT root FROM events)"
KEEP_TASK = "INSERT OR REPLACE INTO tasks (task, root, number, status) VALUES (?, ?, ?, ?)"

MOST_IN_MEMORY = 20_000
"""Events that a journal without a file keeps."""

LOCK_PATIENCE_MS = 3000
"""How long to wait for a central that is just ending to let go of the file."""


class JournalError(TcaError):
    """The journal cannot be written or read any more; central must not go on."""

    def __init__(self, path: str, why: str) -> None:
        self.path, self.why = path, why
        super().__init__(f"journal {path}: {why}")


class Journal:
    """The journal of one central: an async context manager.

    Args:
        path: The SQLite file; None keeps the last events in memory only.

    Raises:
        ConfigError: on entering, the file is no journal of ours, damaged, of a later version, in
            use by another central, or cannot be made.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self.name = str(path) if path else "in memory"
        self._open: aiosqlite.Connection | None = None
        self._queue: Queue = deque()
        self._written = 0
        self._one_at_a_time = asyncio.Lock()
        self.generation = 0

    async def __aenter__(self) -> Self:
        try:
            await self._connect()
            await self._migrate()
            await self._count_start()
        except sqlite3.Error as error:
            await self._close()
            raise ConfigError("journal", self.name, _expected(error)) from error
        except BaseException:
            await self._close()
            raise
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self._close()

    async def write(
        self, records: Sequence[Record], freed: Sequence[Freed], ended: Sequence[Ended]
    ) -> None:
        """Write what happened in one transaction; it is kept when this returns.

        Args:
            records: Events of the tree, in order.
            freed: The nodes that ended with them.
            ended: Top-level tasks, and attachments to messages, that ended with them.

        Raises:
            JournalError: It could not be written.
        """
        async with self._writing():
            self._queue_tree(records, freed, ended)

    @contextlib.asynccontextmanager
    async def _writing(self) -> AsyncIterator[None]:
        """Commit at the end of the block, with no other writer in between."""
        async with self._one_at_a_time:
            try:
                yield
                await self._db.commit()
            except sqlite3.Error as error:
                raise JournalError(self.name, str(error)) from error

    async def transact(self, work: Callable[[aiosqlite.Connection], Awaitable[T]]) -> T:
        """Do ``work`` on the database and commit it, with no other writer in between.

        Raises:
            JournalError: It could not be written.
        """
        async with self._writing():
            return await work(self._db)

    def _queue_tree(
        self, records: Sequence[Record], freed: Sequence[Freed], ended: Sequence[Ended]
    ) -> None:
        begun: dict[str, bool] = {}
        for record in records:
            is_beginning = isinstance(record.event, BEGINNINGS)
            begun[record.root] = begun.get(record.root, False) or is_beginning
        # The end of a forgotten kill must not hide the task that came after all.
        self._queue.append((BEGIN_ROOT, list(begun.items())))
        lines = [*map(_line_of, records), *map(_last_line_of, freed)]
        self._written += len(lines)
        self._queue.append((INSERT_EVENT, lines))
        if freed:
            self._queue.append((KEEP_TASK, [_task_of(free) for free in freed]))
        if ended:
            self._queue.append((END_ROOT, [(end.time, end.root) for end in ended]))
        self._prune()

    async def write_resources(self, changes: Iterable[Changes]) -> None:
        """Write what happened to resources in one transaction; it is kept when this returns.

        Raises:
            JournalError: It could not be written.
        """
        async with self._writing():
            for change in changes:
                names = {status.id: ", ".join(status.names) for status in change.statuses}
                for event in change.records:
                    self._queue_resource_event(event, names)
            self._prune()

    async def living_resource_events(self) -> list[ResourceEvent]:
        """The events of what is declared and of all holds that have not ended, in order.

        Raises:
            JournalError: A line cannot be understood.
        """
        marks = ", ".join("?" * len(KINDS))
        rows = await self._rows(
            f"SELECT number, kind, body FROM events WHERE kind IN ({marks}) AND root IN "  # noqa: S608
            "(SELECT root FROM roots WHERE ended IS NULL) ORDER BY number",
            *KINDS,
        )
        return [self._decode_resource_event(number, kind, body) for number, kind, body in rows]

    async def living_events(self) -> list[RecordedEvent]:
        """The events of all top-level tasks that have not ended, in order.

        Raises:
            JournalError: A line cannot be understood.
        """
        rows = await self._rows(
            "SELECT number, kind, body FROM events WHERE kind != ? AND root NOT LIKE '%/%' "
            "AND root IN (SELECT root FROM roots WHERE ended IS NULL) ORDER BY number",
            END,
        )
        return [self._decode(number, kind, body) for number, kind, body in rows]

    async def find(self, task: str) -> TaskStatus | None:
        """The last status of a task whose top-level task has ended."""
        rows = await self._rows("SELECT status FROM tasks WHERE task = ?", task)
        return TaskStatus.model_validate_json(rows[0][0]) if rows else None

    async def ended_tree(self, task: str) -> list[TaskStatus]:
        """All nodes of the ended top-level task that a task belongs to, parents first."""
        rows = await self._rows(
            "SELECT status FROM tasks WHERE root = (SELECT root FROM tasks WHERE task = ?) "
            "ORDER BY number, rowid DESC",
            task,
        )
        return [TaskStatus.model_validate_json(status) for (status,) in rows]

    async def last_ended(self, most: int) -> list[TaskStatus]:
        """All nodes of the last top-level tasks that ended, oldest first."""
        rows = await self._rows(
            "SELECT t.status FROM tasks t JOIN "
            "(SELECT root, ended FROM roots WHERE ended IS NOT NULL ORDER BY ended DESC LIMIT ?) r "
            "ON r.root = t.root ORDER BY r.ended, t.root, t.number, t.rowid DESC",
            most,
        )
        return [TaskStatus.model_validate_json(status) for (status,) in rows]

    async def read_log(self, question: ReadLog) -> list[LogEntry]:
        """Lines of the history."""
        return await LogReader(self._rows, self._decode).read(question)

    def _decode(self, number: int, kind: str, body: str) -> RecordedEvent:
        try:
            return decode_event(kind, body)
        except ValueError as error:
            raise JournalError(self.name, f"line {number} cannot be read: {error}") from error

    def _decode_resource_event(self, number: int, kind: str, body: str) -> ResourceEvent:
        try:
            return decode_resource_event(kind, body)
        except ValueError as error:
            raise JournalError(self.name, f"line {number} cannot be read: {error}") from error

    def _queue_resource_event(self, event: ResourceEvent, names: dict[str, str]) -> None:
        kind, body = encode_resource_event(event)
        root = event.subject
        ended = event.time if isinstance(event, Finished) else None
        query = "INSERT INTO roots VALUES (?, ?) ON CONFLICT DO UPDATE SET ended = excluded.ended"
        self._queue.append((query, [(root, ended)]))
        subject = root.partition("/")[2]
        line = (event.time, root, subject, names.get(subject, subject), kind, body)
        self._queue.append((INSERT_EVENT, [line]))
        self._written += 1

    def _prune(self) -> None:
        """Forget old history when there is no file to hold it."""
        if self._path is not None or self._written < MOST_IN_MEMORY // 10:
            return
        self._written = 0
        old = (
            "SELECT root FROM roots WHERE ended IS NOT NULL AND root IN "
            "(SELECT root FROM events WHERE number <= (SELECT max(number) - ? FROM events))"
        )
        for table in ("tasks", "events"):
            query = f"DELETE FROM {table} WHERE root IN ({old})"  # noqa: S608
            self._queue.append((query, [(MOST_IN_MEMORY,)]))
        query = (
            "DELETE FROM roots WHERE ended IS NOT NULL AND root NOT IN (SELECT root FROM events)"
        )
        self._queue.append((query, [()]))

    async def _connect(self) -> None:
        if self._path is not None:
            self._make_folder(self._path.parent)
        self._open = await connect(self._path or ":memory:", self._queue)
        await self._db.execute(f"PRAGMA busy_timeout = {LOCK_PATIENCE_MS}")
        # One central per journal: the lock lasts as long as the connection.
        await self._db.execute("PRAGMA locking_mode = EXCLUSIVE")
        await self._db.execute("PRAGMA journal_mode = WAL")
        await self._db.execute("PRAGMA synchronous = FULL")

    def _make_folder(self, folder: Path) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            expected = f"a folder that can be made and written ({error.strerror})"
            raise ConfigError("--data", str(folder), expected) from error

    async def _migrate(self) -> None:
        ours = (await self._rows("PRAGMA application_id"))[0][0]
        version = (await self._rows("PRAGMA user_version"))[0][0]
        tables = (await self._rows("SELECT count(*) FROM sqlite_master"))[0][0]
        scripts = migrations()
        if tables and ours != APPLICATION_ID:
            raise ConfigError("journal", self.name, "a journal of central, or no file")
        if version > len(scripts):
            expected = f"version {len(scripts)} or earlier, not {version}: update this program"
            raise ConfigError("journal", self.name, expected)
        for number, script in enumerate(scripts[version:], version + 1):
            await self._db.executescript(
                f"BEGIN; {script}; PRAGMA application_id = {APPLICATION_ID}; "
                f"PRAGMA user_version = {number}; COMMIT;"
            )

    async def _count_start(self) -> None:
        cursor = await self._db.execute("INSERT INTO starts (time) VALUES (?)", (time.time(),))
        self.generation = cursor.lastrowid or 1
        # A kill whose task never came ends with its tombstone.
        await self._db.execute(
            "UPDATE roots SET ended = ?1 WHERE ended IS NULL "
            "AND root NOT LIKE '%/%' "
            "AND root NOT IN (SELECT root FROM events "
            "WHERE kind IN ('Submitted', 'Prepared', 'Registered')) "
            "AND root NOT IN (SELECT root FROM events WHERE time > ?1 - ?2)",
            (time.time(), TOMBSTONE_SECONDS),
        )
        await self._db.commit()

    async def _rows(self, query: str, *values: object) -> list[Any]:
        async with self._db.execute(query, values) as cursor:
            return list(await cursor.fetchall())

    @property
    def _db(self) -> aiosqlite.Connection:
        if self._open is None:
            raise JournalError(self.name, "it is closed")
        return self._open

    async def _close(self) -> None:
        if self._open is not None:
            await self._open.close()
            self._open = None


def _line_of(record: Record) -> tuple[Any, ...]:
    kind, body = encode_event(record.event)
    event = record.event
    return event.time, record.root, event.id, record.name, kind, body


def _last_line_of(free: Freed) -> tuple[Any, ...]:
    status = free.status
    body = status.model_dump_json(exclude={"data", "result"})
    return status.ended or status.created, free.root, status.id, status.name, END, body


def _task_of(free: Freed) -> tuple[Any, ...]:
    """A row of the ended tasks; parents are made before their children, and so come first."""
    status = free.status
    return status.id, free.root, round(status.created * 1e6), status.model_dump_json()


def migrations() -> list[str]:
    """The migration scripts, in order."""
    folder = resources.files("tca_bus") / "migrations"
    files = sorted(file.name for file in folder.iterdir() if file.name.endswith(".sql"))
    return [(folder / name).read_text(encoding="utf-8") for name in files]


def _expected(error: sqlite3.Error) -> str:
    if "locked" in str(error):
        return "a file that no other central uses; stop that one or choose another --data"
    return f"an intact journal of central ({error}); move it away to begin a new one"
