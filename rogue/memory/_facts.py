"""What is known of the world."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field

import aiosqlite

from rogue.memory._database import Database
from rogue.outcomes import Thing


@dataclass(frozen=True, slots=True)
class Facts:
    """What is known of the world: the robot's room, and (user, item) of what is on the tray."""

    room: str | None = None
    tray: frozenset[Thing] = field(default_factory=frozenset)

    def changed(
        self, *, room: str | None, placed: Iterable[Thing] = (), gone: Iterable[Thing] = ()
    ) -> Facts:
        """The facts once the robot is in ``room`` and things have come and gone."""
        return Facts(room, (self.tray | set(placed)) - set(gone))


class KeptFacts:
    """The part of the store that holds what is known of the world."""

    _base: Database

    async def facts(self) -> Facts:
        """What is known of the world."""
        rows = await self._base.rows("SELECT kind, subject FROM facts")
        rooms = [subject for kind, subject in rows if kind == "robot"]
        tray = (json.loads(subject) for kind, subject in rows if kind == "tray")
        return Facts(rooms[0] if rooms else None, frozenset((user, item) for user, item in tray))

    async def move_things(
        self, *, placed: Iterable[Thing] = (), gone: Iterable[Thing] = ()
    ) -> None:
        """Keep that things were put on the tray or taken from it, whoever did it."""
        async with self._base.transaction() as link:
            await write_things(link, placed, gone)


async def write_room(link: aiosqlite.Connection, room: str | None) -> None:
    """Write where the robot is."""
    await link.execute("DELETE FROM facts WHERE kind = 'robot'")
    if room is not None:
        await link.execute("INSERT INTO facts (kind, subject) VALUES ('robot', ?)", (room,))


async def write_things(
    link: aiosqlite.Connection, placed: Iterable[Thing], gone: Iterable[Thing]
) -> None:
    """Write what came to the tray and what left it."""
    await link.executemany(
        "INSERT OR IGNORE INTO facts (kind, subject) VALUES ('tray', ?)",
        [(json.dumps(thing),) for thing in placed],
    )
    await link.executemany(
        "DELETE FROM facts WHERE kind = 'tray' AND subject = ?",
        [(json.dumps(thing),) for thing in gone],
    )
