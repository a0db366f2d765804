"""The lines of the conversation."""

from __future__ import annotations

from rogue.memory._database import Database
from rogue.messages import TraceLine


class KeptLines:
    """The part of the store that holds the conversation."""

    _base: Database

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

    async def lines(self, after: int, most: int, *, since: float | None = None) -> list[TraceLine]:
        """Lines of the conversation after number ``after``, said at ``since`` or later."""
        rows = await self._base.rows(
            "SELECT seq, time, text FROM trace WHERE seq > ? AND time >= coalesce(?, time) "
            "ORDER BY seq LIMIT ?",
            after,
            since,
            most,
        )
        return [TraceLine(seq=seq, time=time, text=text) for seq, time, text in rows]
