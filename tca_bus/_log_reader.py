"""Reads the task history from the journal: lines with what is known of the nodes they are about."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from tca_bus._history import NodeFacts, Told, tell_end, tell_event
from tca_bus._log_statements import NodeRef
from tca_bus._protocol import LogEntry, ReadLog, TaskStatus
from tca_bus.tasktree import RecordedEvent

END = "Ended"
"""Kind of the line that says how a node ended; it is no input of the tree."""

FIRST = "Submitted"
"""Kind of the first line of a node; its number is the node's number in the log."""

AT_ONCE = 500
"""Ids in one look-up; SQLite bounds the values of a statement."""

Rows = Callable[..., Awaitable[list[Any]]]
Decode = Callable[[int, str, str], RecordedEvent]


@dataclass(frozen=True, slots=True)
class _First:
    """What the first line of a node says."""

    node: NodeRef
    task: dict[str, Any]
    previous: str | None
    is_held: bool

    def relatives(self) -> list[str]:
        return [id for id in (self.task.get("parent"), self.previous) if id]


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
        known = await self._firsts(row[3] for row in found)
        missing = {id for first in known.values() for id in first.relatives()} - set(known)
        known |= await self._firsts(missing)
        return [self._entry(row, known) for row in found]

    async def _before_last(self, count: int, where: str, values: Sequence[Any]) -> int:
        query = f"SELECT number FROM events WHERE 1{where} ORDER BY number DESC LIMIT 1 OFFSET ?"  # noqa: S608
        rows = await self.rows(query, *values, count)
        return int(rows[0][0]) if rows else 0

    async def _firsts(self, ids: Iterable[str]) -> dict[str, _First]:
        wanted = list(dict.fromkeys(ids))
        known: dict[str, _First] = {}
        for start in range(0, len(wanted), AT_ONCE):
            part = wanted[start : start + AT_ONCE]
            query = (
                "SELECT task, min(number), name, body FROM events "  # noqa: S608
                f"WHERE kind = ? AND task IN ({_marks(part)}) GROUP BY task"
            )
            for task, number, name, body in await self.rows(query, FIRST, *part):
                known[task] = _first(number, name, json.loads(body))
        return known

    def _entry(self, row: Sequence[Any], known: dict[str, _First]) -> LogEntry:
        number, when, root, task, name, kind, body = row
        first = known.get(task) or _First(NodeRef(name=name), {}, None, is_held=False)
        facts = _facts(first, known)
        told = self._tell(number, kind, body, facts)
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
            data=first.task.get("data") if kind == FIRST else None,
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


def _first(number: int, name: str, body: dict[str, Any]) -> _First:
    return _First(
        NodeRef(name=name, number=number),
        body["task"],
        body.get("previous"),
        is_held=bool(body.get("waits")),
    )


def _facts(first: _First, known: dict[str, _First]) -> NodeFacts:
    return NodeFacts(
        node=first.node,
        task_class=first.task.get("task_class", "goal"),
        sender=first.task.get("sender", "*"),
        parent=first.task.get("parent"),
        was_held=first.is_held,
        relatives={id: known[id].node for id in first.relatives() if id in known},
    )
