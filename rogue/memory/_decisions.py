"""What was decided about each request; written with what is committed next, and bounded."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterable
from dataclasses import asdict

import aiosqlite

from rogue.explain import Decision, DecisionKind, Rival
from rogue.memory._database import Database, Row

log = logging.getLogger(__name__)

MOST = 200
"""Decisions kept of one request; of more the oldest routine ones are forgotten."""

MOST_WAITING = 10_000
"""Decisions that may wait for the next commit; of more the oldest are forgotten."""

MOST_OVER = 12
"""Alternatives kept of one decision."""

_FIELDS = ("rule", "chosen", "over", "rivals", "reason", "until")


class KeptDecisions:
    """The part of the store that holds decisions.

    A decision costs no wait of its own: it rides on the next commit, and every step that the
    robot takes is committed before it begins.
    """

    _base: Database
    _waiting: list[Decision]

    def record(self, decisions: Iterable[Decision]) -> None:
        """Keep decisions; on disk with whatever is written next, or after ``flush``."""
        self._waiting.extend(decisions)
        if len(self._waiting) > MOST_WAITING:
            dropped = len(self._waiting) - MOST_WAITING
            log.warning("%d decisions were forgotten: nothing was written meanwhile", dropped)
            del self._waiting[:dropped]

    async def flush(self) -> None:
        """Write what was recorded; it is on disk when this returns."""
        if self._waiting:
            async with self._base.transaction():
                pass

    async def decisions(self, request_id: str) -> list[Decision]:
        """What was decided about a request, the oldest first."""
        await self.flush()
        rows = await self._base.rows(
            "SELECT request, time, kind, record FROM decisions WHERE request = ? ORDER BY number",
            request_id,
        )
        return [_decision(row) for row in rows]

    async def forgotten(self, request_id: str) -> int:
        """How many decisions about a request were forgotten."""
        found = await self._base.row(
            "SELECT decisions FROM forgotten WHERE request = ?", request_id
        )
        return int(found[0]) if found else 0

    async def _write_decisions(self, link: aiosqlite.Connection) -> None:
        """Write what waits in a transaction that is about to be committed."""
        if not self._waiting:
            return
        batch, self._waiting = self._waiting, []
        try:
            await link.executemany(
                "INSERT INTO decisions (request, time, kind, routine, record) "
                "VALUES (?, ?, ?, ?, ?)",
                [row for decision in batch for row in _rows(decision)],
            )
            for request_id in {name for decision in batch for name in decision.requests}:
                await _thin(link, request_id)
        except BaseException:
            self._waiting = [*batch, *self._waiting]
            raise


async def _thin(link: aiosqlite.Connection, request_id: str) -> None:
    """Forget the oldest routine decisions beyond the most, then the oldest others."""
    cursor = await link.execute(
        "DELETE FROM decisions WHERE number IN (SELECT number FROM decisions WHERE request = ?1 "
        "ORDER BY routine DESC, number LIMIT max(0, "
        "(SELECT count(*) FROM decisions WHERE request = ?1) - ?2))",
        (request_id, MOST),
    )
    if cursor.rowcount > 0:
        await link.execute(
            "INSERT INTO forgotten (request, decisions) VALUES (?1, ?2) "
            "ON CONFLICT (request) DO UPDATE SET decisions = decisions + ?2",
            (request_id, cursor.rowcount),
        )


def _rows(decision: Decision) -> list[Row]:
    fields = {name: value for name, value in asdict(decision).items() if name in _FIELDS and value}
    if "over" in fields:
        fields["over"] = fields["over"][:MOST_OVER]
    record = json.dumps(fields)
    kind, routine = decision.kind.value, decision.is_routine
    return [(name, decision.time, kind, routine, record) for name in decision.requests]


def _decision(row: Row) -> Decision:
    request, time, kind, record = row
    fields = json.loads(record)
    rivals = tuple(Rival(**rival) for rival in fields.pop("rivals", ()))
    return Decision(
        time=time,
        kind=DecisionKind(kind),
        requests=(request,),
        rivals=rivals,
        over=tuple(fields.pop("over", ())),
        **fields,
    )
