"""Reads the task history from the journal: lines with what is known of the nodes they are about."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tca_bus._history import NodeFacts, Told, tell_end, tell_event
from tca_bus._log_statements import NodeRef
from tca_bus._protocol import LogEntry, ReadLog, TaskStatus
from tca_bus.tasktree import RecordedEvent

END = "Ended"
"""Kind of the line that says how a node ended; it is no input of the tree."""

SENT = "Submitted"
BEGINNINGS = (SENT, "Prepared")
"""Kinds of the lines that tell of a node; the number of the first is the node's in the log."""

AT_ONCE = 500
"""Ids in one look-up; SQLite bounds the values of a statement."""

Rows = Callable[..., Awaitable[list[Any]]]
Decode = Callable[[int, str, str], RecordedEvent]


@dataclass(slots=True)
class _Known:
    """What the first lines of a node say."""

    node: NodeRef
    task: dict[str, Any]
    is_held: bool


@dataclass(frozen=True, slots=True)
class LogReader:
    """Reads pages of the history.

    ``rows`` runs a query with its values, ``decode`` makes an event of number, kind and body.
    """

    rows: Rows
    decode: Decode

    async def read(self, question: ReadLog) -> list[LogEntry]:
        """The lines after a number; below zero it counts from the end: the last so many."""
        where, values = _conditions(question)
        after = question.after
        if after < 0:
            after = await self._before_last(-after, where, values)
        query = f"SELECT * FROM events WHERE number > ?{where} ORDER BY number LIMIT ?"  # noqa: S608
        found = await self.rows(query, after, *values, question.most)
        bodies = [json.loads(row[6]) for row in found]
        ids = {row[3] for row in found} | {id for body in bodies for id in _ids_in(body)}
        known = await self._known(ids)
        parents = {one.task["parent"] for one in known.values() if one.task.get("parent")}
        known |= await self._known(parents - known.keys())
        return [self._entry(*pair, known) for pair in zip(found, bodies, strict=True)]

    async def _before_last(self, count: int, where: str, values: Sequence[Any]) -> int:
        query = f"SELECT number FROM events WHERE 1{where} ORDER BY number DESC LIMIT 1 OFFSET ?"  # noqa: S608
        rows = await self.rows(query, *values, count)
        return int(rows[0][0]) if rows else 0

    async def _known(self, ids: Collection[str]) -> dict[str, _Known]:
        wanted = sorted(ids)
        known: dict[str, _Known] = {}
        for start in range(0, len(wanted), AT_ONCE):
            part = wanted[start : start + AT_ONCE]
            query = (
                "SELECT task, number, name, body FROM events WHERE kind IN (?, ?) "  # noqa: S608
                f"AND task IN ({_marks(part)}) ORDER BY number"
            )
            for task, number, name, body in await self.rows(query, *BEGINNINGS, *part):
                told = json.loads(body)
                one = known.setdefault(task, _Known(NodeRef(name=name, number=number), {}, False))
                one.task, one.is_held = told.get("task", told), bool(told.get("waits"))
        return known

    def _entry(
        self, row: Sequence[Any], body: dict[str, Any], known: dict[str, _Known]
    ) -> LogEntry:
        number, when, root, task, name, kind, text = row
        facts = _facts(task, name, known)
        told = self._tell(number, kind, text, facts)
        return LogEntry(
            number=number,
            time=when,
            task=task,
            name=name,
            event=told.event,
            text=told.text,
            root=root,
            node=facts.node.number,
            task_class=facts.task_class,
            data=body["task"].get("data") if kind == SENT else None,
            statements=told.statements,
        )

    def _tell(self, number: int, kind: str, body: str, facts: NodeFacts) -> Told:
        if kind == END:
            return tell_end(TaskStatus.model_validate_json(body), facts)
        return tell_event(self.decode(number, kind, body), facts)


def _conditions(question: ReadLog) -> tuple[str, list[str]]:
    where, values = "", list[str]()
    if question.task is not None:
        where += " AND (task = ? OR root = ?)"
        values += [question.task, question.task]
    if question.messages:
        where += f" AND name IN ({_marks(question.messages)})"
        values += question.messages
    if question.ignore:
        where += f" AND name NOT IN ({_marks(question.ignore)})"
        values += question.ignore
    return where, values


def _marks(values: Sequence[str]) -> str:
    return ", ".join("?" * len(values))


def _ids_in(body: dict[str, Any]) -> Iterator[str]:
    """The ids of other nodes that an event names."""
    task = body.get("task")
    orders = [body.get("order")]
    if isinstance(task, dict):
        orders += task.get("orders", ())
    for order in orders:
        for point in ("first", "then"):
            named = (order or {}).get(point)
            if named:
                yield named["task"]
    for field in ("previous", "context", "parent"):
        if body.get(field):
            yield body[field]


def _facts(task: str, name: str, known: dict[str, _Known]) -> NodeFacts:
    one = known.get(task) or _Known(NodeRef(name=name or "*"), {}, is_held=False)
    monitor = one.task.get("monitor")
    return NodeFacts(
        node=one.node,
        task_class=one.task.get("task_class", "goal"),
        sender=one.task.get("sender", "*"),
        parent=one.task.get("parent"),
        was_held=one.is_held,
        monitor=monitor["kind"] if monitor else None,
        nodes={id: other.node for id, other in known.items()},
    )
