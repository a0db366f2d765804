"""What the agent must not forget: requests, what is on the tray, steps and the conversation."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self

import aiosqlite

from rogue.memory._database import Database, Row
from rogue.messages import DeliveryRequest, RequestState, StepView, TraceLine
from rogue.outcomes import Outcome, StepOutcome

FILE_NAME = "rogue.db"

_COLUMNS = tuple(DeliveryRequest.model_fields)
_REQUEST_COLUMNS = ", ".join(_COLUMNS)
_OPEN_STATES = tuple(state.value for state in RequestState if not state.is_final)
_OPEN = f"state IN ({', '.join(repr(state) for state in _OPEN_STATES)})"


@dataclass(frozen=True, slots=True)
class Step:
    """One operator that is carried out; ``requests`` are the ids of those that it serves."""

    number: int
    operator: str
    arguments: tuple[str, ...]
    requests: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Facts:
    """What is known of the world: the robot's room, and (user, item) of what is on the tray."""

    room: str | None = None
    tray: frozenset[tuple[str, str]] = field(default_factory=frozenset)


class Store:
    """The agent's memory in ``folder``/rogue.db; an async context manager.

    Every method that writes has written, for good, when it returns.
    """

    def __init__(self, folder: Path) -> None:
        self._base = Database(folder / FILE_NAME)

    async def __aenter__(self) -> Self:
        await self._base.__aenter__()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self._base.__aexit__(kind, error, trace)

    async def identity(self) -> str:
        """A name that this store was born with, so that task ids of two stores never meet."""
        found = await self._base.row("SELECT name FROM identity")
        return str(found[0]) if found else ""

    async def add_request(self, request: DeliveryRequest, why: str | None) -> None:
        """Keep a new request."""
        places = ", ".join("?" * 12)
        async with self._base.transaction() as link:
            await link.execute(
                f"INSERT INTO requests ({_REQUEST_COLUMNS}, why) VALUES ({places})",  # noqa: S608
                (*request.model_dump(mode="json").values(), why),
            )

    async def request(self, request_id: str) -> DeliveryRequest | None:
        """The request of that id."""
        rows = await self._requests("WHERE id = ?", request_id)
        return rows[0] if rows else None

    async def why(self, request_id: str) -> str | None:
        """The words in which the user said what the request is for."""
        found = await self._base.row("SELECT why FROM requests WHERE id = ?", request_id)
        return found[0] if found else None

    async def requests(self, *, open_only: bool = False) -> list[DeliveryRequest]:
        """All requests, or those that have not ended, the oldest first."""
        return await self._requests(f"WHERE {_OPEN}" if open_only else "")

    async def change_request(self, request: DeliveryRequest, *, note: str | None = None) -> bool:
        """Keep state, end and reason of a request, unless it has ended; says whether it did so."""
        async with self._base.transaction() as link:
            return await _change(link, request, note)

    async def add_note(self, request_id: str, time: float, text: str) -> None:
        """Keep a sentence on why a request stands where it does."""
        async with self._base.transaction() as link:
            await _note(link, request_id, time, text)

    async def notes(self, request_id: str) -> list[tuple[float, str]]:
        """Times and sentences kept for a request."""
        rows = await self._base.rows(
            "SELECT time, text FROM notes WHERE request = ? ORDER BY number", request_id
        )
        return [(float(time), str(text)) for time, text in rows]

    async def facts(self) -> Facts:
        """What is known of the world."""
        rows = await self._base.rows("SELECT kind, subject FROM facts")
        rooms = [subject for kind, subject in rows if kind == "robot"]
        tray = (json.loads(subject) for kind, subject in rows if kind == "tray")
        return Facts(rooms[0] if rooms else None, frozenset((user, item) for user, item in tray))

    async def begin_step(
        self,
        operator: str,
        arguments: Sequence[str],
        requests: Iterable[DeliveryRequest],
        time: float,
    ) -> Step:
        """Write down a step before it starts, with the requests that it serves as they are then."""
        served = list(requests)
        ids = tuple(request.id for request in served)
        async with self._base.transaction() as link:
            cursor = await link.execute(
                "INSERT INTO steps (operator, arguments, requests, state, started) "
                "VALUES (?, ?, ?, 'open', ?)",
                (operator, json.dumps(arguments), json.dumps(ids), time),
            )
            for request in served:
                await _change(link, request, None)
        return Step(int(cursor.lastrowid or 0), operator, tuple(arguments), ids)

    async def open_step(self) -> Step | None:
        """The step that was begun and not ended, if there is one."""
        rows = await self._base.rows(
            "SELECT number, operator, arguments, requests FROM steps WHERE state = 'open' "
            "ORDER BY number DESC LIMIT 1"
        )
        return _step(rows[0]) if rows else None

    async def end_step(
        self,
        step: Step,
        outcome: StepOutcome,
        facts: Facts,
        time: float,
        *,
        changed: Iterable[DeliveryRequest] = (),
    ) -> list[DeliveryRequest]:
        """Close a step together with what it changed in the world and for the requests.

        Gives those of ``changed`` that had not ended already, by somebody else's hand.
        """
        async with self._base.transaction() as link:
            await link.execute(
                "UPDATE steps SET state = ?, outcome = ?, ended = ? WHERE number = ?",
                (outcome.kind, outcome.model_dump_json(), time, step.number),
            )
            await link.execute("DELETE FROM outcomes WHERE step = ?", (step.number,))
            await link.execute("DELETE FROM facts")
            known = [("tray", json.dumps(pair)) for pair in sorted(facts.tray)]
            if facts.room is not None:
                known.append(("robot", facts.room))
            await link.executemany("INSERT INTO facts (kind, subject) VALUES (?, ?)", known)
            return [r for r in changed if await _change(link, r, r.reason)]

    async def steps_of(self, request_id: str) -> list[StepView]:
        """What was carried out for a request."""
        rows = await self._base.rows(
            "SELECT operator, arguments, state, started, ended, outcome FROM steps "
            "WHERE EXISTS (SELECT 1 FROM json_each(requests) WHERE value = ?) ORDER BY number",
            request_id,
        )
        return [_view(row) for row in rows]

    async def keep_outcome(self, step: Step, position: int, outcome: Outcome) -> None:
        """Keep what came of effect number ``position`` of an open step."""
        async with self._base.transaction() as link:
            await link.execute(
                "INSERT OR REPLACE INTO outcomes (step, position, outcome) VALUES (?, ?, ?)",
                (step.number, position, outcome.model_dump_json()),
            )

    async def outcomes(self, step: Step) -> dict[int, Outcome]:
        """What came of the effects of an open step so far, by their positions."""
        rows = await self._base.rows(
            "SELECT position, outcome FROM outcomes WHERE step = ?", step.number
        )
        return {int(position): Outcome.model_validate_json(text) for position, text in rows}

    async def add_line(
        self, text: str, time: float, *, step: int | None = None, position: int | None = None
    ) -> TraceLine | None:
        """Keep a line of the conversation; None when this line of the step is there already."""
        async with self._base.transaction() as link:
            cursor = await link.execute(
                "INSERT OR IGNORE INTO trace (time, text, step, position) VALUES (?, ?, ?, ?)",
                (time, text, step, position),
            )
            if cursor.rowcount < 1:
                return None
            return TraceLine(seq=int(cursor.lastrowid or 0), time=time, text=text)

    async def lines(self, after: int, most: int) -> list[TraceLine]:
        """Lines of the conversation after number ``after``."""
        rows = await self._base.rows(
            "SELECT seq, time, text FROM trace WHERE seq > ? ORDER BY seq LIMIT ?", after, most
        )
        return [TraceLine(seq=seq, time=time, text=text) for seq, time, text in rows]

    async def _requests(self, where: str, *values: object) -> list[DeliveryRequest]:
        rows = await self._base.rows(
            f"SELECT {_REQUEST_COLUMNS} FROM requests {where} ORDER BY number",  # noqa: S608
            *values,
        )
        return [DeliveryRequest(**dict(zip(_COLUMNS, row, strict=True))) for row in rows]


async def _change(link: aiosqlite.Connection, request: DeliveryRequest, note: str | None) -> bool:
    cursor = await link.execute(
        f"UPDATE requests SET state = ?, finished = ?, reason = ? WHERE id = ? AND {_OPEN}",  # noqa: S608
        (request.state.value, request.finished, request.reason, request.id),
    )
    changed = cursor.rowcount > 0
    if changed and note:
        await _note(link, request.id, request.finished or request.posted, note)
    return changed


async def _note(link: aiosqlite.Connection, request_id: str, time: float, text: str) -> None:
    await link.execute(
        "INSERT INTO notes (request, time, text) VALUES (?, ?, ?)", (request_id, time, text)
    )


def _step(row: Row) -> Step:
    number, operator, arguments, requests = row
    return Step(int(number), operator, tuple(json.loads(arguments)), tuple(json.loads(requests)))


def _view(row: Row) -> StepView:
    operator, arguments, state, started, ended, outcome = row
    reason = StepOutcome.model_validate_json(outcome).reason if outcome else None
    return StepView(
        operator=f"{operator} {' '.join(json.loads(arguments))}",
        state=state,
        started=started,
        ended=ended,
        outcome=reason,
    )
