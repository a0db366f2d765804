"""People who are in no directory, as they were when they were met."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from rogue.memory._database import Database


class KeptPeople:
    """The part of the store that holds people, by login name."""

    _base: Database

    async def add_person(self, user: str, person: Mapping[str, Any]) -> None:
        """Keep somebody, in the place of what was known of them before."""
        async with self._base.transaction() as link:
            await link.execute(
                "INSERT OR REPLACE INTO people (user, person) VALUES (?, ?)",
                (user, json.dumps(person)),
            )

    async def people(self) -> dict[str, dict[str, Any]]:
        """All who are kept."""
        rows = await self._base.rows("SELECT user, person FROM people")
        return {str(user): json.loads(person) for user, person in rows}
