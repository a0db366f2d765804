"""What is known of the world."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import aiosqlite

from rogue.memory._database import Database


@dataclass(frozen=True, slots=True)
class Facts:
    """What is known of the world: the robot's room, and (user, item) of what is on the tray."""

    room: str | None = None
    tray: frozenset[tuple[str, str]] = field(default_factory=frozenset)


class KeptFacts:
    """The part of the store that holds what is known of the world."""

    _base: Database

    async def facts(self) -> Facts:
        """What is known of the world."""
        rows = await self._base.rows("SELECT kind, subject FROM facts")
        rooms = [subject for kind, subject in rows if kind == "robot"]
        tray = (json.loads(subject) for kind, subject in rows if kind == "tray")
        return Facts(rooms[0] if rooms else None, frozenset((user, item) for user, item in tray))


async def write_facts(link: aiosqlite.Connection, facts: Facts) -> None:
    """Put ``facts`` in the place of what was known before."""
    await link.execute("DELETE FROM facts")
    known = [("tray", json.dumps(pair)) for pair in sorted(facts.tray)]
    if facts.room is not None:
        known.append(("robot", facts.room))
    await link.executemany("INSERT INTO facts (kind, subject) VALUES (?, ?)", known)
