"""What the agent must not forget: requests, what is on the tray, steps and the conversation."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Self

from rogue.memory._database import Database
from rogue.memory._decisions import KeptDecisions
from rogue.memory._holds import KeptHolds
from rogue.memory._lines import KeptLines
from rogue.memory._people import KeptPeople
from rogue.memory._withdrawals import Withdrawals

FILE_NAME = "rogue.db"


class Store(Withdrawals, KeptHolds, KeptLines, KeptDecisions, KeptPeople):
    """The agent's memory in ``folder``/rogue.db; an async context manager.

    Every method that writes has written, for good, when it returns; but for ``record``, which
    leaves that to the next.
    """

    def __init__(self, folder: Path) -> None:
        self._waiting = []
        self._base = Database(folder / FILE_NAME, self._write_decisions)

    async def __aenter__(self) -> Self:
        await self._base.__aenter__()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            await self.flush()
        finally:
            await self._base.__aexit__(kind, error, trace)

    async def identity(self) -> str:
        """A name that this store was born with, so that task ids of two stores never meet."""
        found = await self._base.row("SELECT name FROM identity")
        return str(found[0]) if found else ""
