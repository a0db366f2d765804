"""Errands that are put off until later."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import aiosqlite

from rogue.memory._database import Database
from rogue.outcomes import Trouble
from rogue.times import show_time


@dataclass(frozen=True, slots=True)
class Hold:
    """An errand that waits until a time, in seconds since the epoch, for what ails ``room``.

    ``reason`` is what the matter is.
    """

    request: str
    room: str
    until: float
    reason: str
    trouble: Trouble

    @property
    def outlook(self) -> str:
        """What the matter is, and when it is tried again."""
        return f"{self.reason}; trying again after {show_time(self.until)}"


class KeptHolds:
    """The part of the store that holds what is put off."""

    _base: Database

    async def holds(self) -> list[Hold]:
        """What is put off, whether its time has come or not."""
        rows = await self._base.rows(
            "SELECT request, room, until, reason, trouble FROM holds ORDER BY request"
        )
        return [
            Hold(str(request), str(room), float(until), str(reason), Trouble(str(trouble)))
            for request, room, until, reason, trouble in rows
        ]

    async def put_off(self, holds: Iterable[Hold]) -> None:
        """Put errands off."""
        async with self._base.transaction() as link:
            await write_holds(link, holds)

    async def take_up(self, requests: Iterable[str]) -> None:
        """Let errands that were put off go on."""
        async with self._base.transaction() as link:
            await link.executemany(
                "DELETE FROM holds WHERE request = ?", [(request,) for request in requests]
            )


async def write_holds(link: aiosqlite.Connection, holds: Iterable[Hold]) -> None:
    """Write what is put off; the latest word on an errand stands."""
    await link.executemany(
        "INSERT OR REPLACE INTO holds (request, room, until, reason, trouble) "
        "VALUES (?, ?, ?, ?, ?)",
        [(h.request, h.room, h.until, h.reason, h.trouble.value) for h in holds],
    )
