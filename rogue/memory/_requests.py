"""The requests as they are kept, and the sentences that were noted on each."""

from __future__ import annotations

import json
from collections.abc import Collection

import aiosqlite

from rogue.memory._database import Database, Row
from rogue.messages import DeliveryRequest, Filled, RequestState

_COLUMNS = tuple(DeliveryRequest.model_fields)
_REQUEST_COLUMNS = ", ".join(f'"{column}"' for column in _COLUMNS)
_OPEN_STATES = tuple(state.value for state in RequestState if not state.is_final)
_OPEN = f"state IN ({', '.join(repr(state) for state in _OPEN_STATES)})"

_CHANGE = (
    "UPDATE requests SET state = ?, finished = ?, reason = ?, "  # noqa: S608
    f"warning = CASE WHEN ? THEN NULL ELSE warning END WHERE id = ? AND {_OPEN}"
)

_WARN = f"UPDATE requests SET warning = ? WHERE id = ? AND {_OPEN}"  # noqa: S608


class KeptRequests:
    """The part of the store that holds requests."""

    _base: Database

    async def add_request(
        self, request: DeliveryRequest, why: str | None, filled: tuple[Filled, ...] = ()
    ) -> None:
        """Keep a new request, and what of it was filled in."""
        places = ", ".join("?" * (len(_COLUMNS) + 2))
        told = json.dumps([one.model_dump() for one in filled])
        async with self._base.transaction() as link:
            await link.execute(
                f"INSERT INTO requests ({_REQUEST_COLUMNS}, why, filled) VALUES ({places})",  # noqa: S608
                (*_values(request), why, told),
            )

    async def request(self, request_id: str) -> DeliveryRequest | None:
        """The request of that id."""
        rows = await self._requests("WHERE id = ?", request_id)
        return rows[0] if rows else None

    async def why(self, request_id: str) -> str | None:
        """The words in which the user said what the request is for."""
        found = await self._base.row("SELECT why FROM requests WHERE id = ?", request_id)
        return found[0] if found else None

    async def filled(self, request_id: str) -> list[Filled]:
        """What of a request was filled in, and from where."""
        found = await self._base.row("SELECT filled FROM requests WHERE id = ?", request_id)
        return [Filled.model_validate(one) for one in json.loads(found[0])] if found else []

    async def latest_ids(self, most: int = 1000) -> list[str]:
        """The ids of the requests that were posted last."""
        rows = await self._base.rows("SELECT id FROM requests ORDER BY number DESC LIMIT ?", most)
        return [str(row[0]) for row in rows]

    async def requests(
        self,
        *,
        open_only: bool = False,
        states: Collection[RequestState] = (),
        user: str | None = None,
        most: int | None = None,
    ) -> list[DeliveryRequest]:
        """Requests, the oldest first.

        All, or those that have not ended, are in one of ``states``, are for ``user``; of these
        the latest ``most``.
        """
        where, values = ["1"], list[object]()
        if open_only:
            where.append(_OPEN)
        if states:
            where.append(f"state IN ({', '.join('?' * len(states))})")
            values += [state.value for state in states]
        if user is not None:
            where.append("user = ?")
            values.append(user)
        clause = f"WHERE {' AND '.join(where)} ORDER BY number DESC LIMIT ?"
        found = await self._requests(clause, *values, -1 if most is None else most)
        return found[::-1]

    async def change_request(self, request: DeliveryRequest, *, note: str | None = None) -> bool:
        """Keep state, end and reason of a request, unless it has ended; says whether it did so."""
        async with self._base.transaction() as link:
            return await write_change(link, request, note)

    async def warn(self, request_id: str, warning: str | None, *, note: str, time: float) -> bool:
        """Keep what is to be feared for a request, unless it has ended; says whether it did so."""
        async with self._base.transaction() as link:
            cursor = await link.execute(_WARN, (warning, request_id))
            if cursor.rowcount > 0:
                await write_note(link, request_id, time, note)
            return cursor.rowcount > 0

    async def add_note(self, request_id: str, time: float, text: str) -> None:
        """Keep a sentence on why a request stands where it does."""
        async with self._base.transaction() as link:
            await write_note(link, request_id, time, text)

    async def notes(self, request_id: str) -> list[tuple[float, str]]:
        """Times and sentences kept for a request."""
        rows = await self._base.rows(
            "SELECT time, text FROM notes WHERE request = ? ORDER BY number", request_id
        )
        return [(float(time), str(text)) for time, text in rows]

    async def _requests(self, where: str, *values: object) -> list[DeliveryRequest]:
        rows = await self._base.rows(
            f"SELECT {_REQUEST_COLUMNS} FROM requests {where}",  # noqa: S608
            *values,
        )
        return [_request(row) for row in rows]


async def write_change(
    link: aiosqlite.Connection, request: DeliveryRequest, note: str | None
) -> bool:
    """Write state, end and reason of a request, unless it has ended; says whether it did so.

    A note is of the time at which the request ended, or began to close.
    """
    state = request.state
    values = (state.value, request.finished, request.reason, state.is_final, request.id)
    cursor = await link.execute(_CHANGE, values)
    changed = cursor.rowcount > 0
    if changed and note:
        since = request.closing.since if request.closing else request.posted
        await write_note(link, request.id, request.finished or since, note)
    return changed


async def write_course(link: aiosqlite.Connection, request: DeliveryRequest, time: float) -> None:
    """Write where an open request goes on, unless it was decided already how it closes."""
    closing = request.closing
    cursor = await link.execute(
        'UPDATE requests SET pickup = ?, deliver = ?, "then" = ?, closing = ? '
        "WHERE id = ? AND closing IS NULL",
        (
            request.pickup,
            request.deliver,
            request.then,
            closing.model_dump_json() if closing else None,
            request.id,
        ),
    )
    if closing is not None and cursor.rowcount > 0:
        await write_note(link, request.id, time, closing.reason)


async def write_note(link: aiosqlite.Connection, request_id: str, time: float, text: str) -> None:
    """Write a sentence on a request."""
    await link.execute(
        "INSERT INTO notes (request, time, text) VALUES (?, ?, ?)", (request_id, time, text)
    )


def _values(request: DeliveryRequest) -> list[object]:
    values = request.model_dump(mode="json").values()
    return [json.dumps(value) if isinstance(value, dict) else value for value in values]


def _request(row: Row) -> DeliveryRequest:
    values = dict(zip(_COLUMNS, row, strict=True))
    if values["closing"] is not None:
        values["closing"] = json.loads(values["closing"])
    return DeliveryRequest(**values)
