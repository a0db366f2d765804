"""The conversation that the trace shows: kept first, then told to whoever listens."""

from __future__ import annotations

import logging
from collections.abc import Iterable

from rogue.memory import Store
from rogue.messages import TraceLine
from tca_bus import Broadcast, Module, TcaError

log = logging.getLogger(__name__)


class Conversation:
    """Writes lines to the store and broadcasts them."""

    def __init__(self, module: Module, store: Store) -> None:
        self._module = module
        self._store = store

    async def tell(self, line: str) -> None:
        """Say a line."""
        await self._send(await self._store.add_line(line, self._module.clock.now()))

    async def tell_all(self, lines: Iterable[str]) -> None:
        """Say some lines."""
        for line in lines:
            await self.tell(line)

    async def tell_step(self, line: str, step: int, position: int) -> None:
        """Say a line of a step; one that was said before a crash is not said again."""
        now = self._module.clock.now()
        await self._send(await self._store.add_line(line, now, step=step, position=position))

    async def _send(self, line: TraceLine | None) -> None:
        if line is not None:
            await announce(self._module, line)


async def announce(module: Module, message: Broadcast) -> None:
    """Broadcast what is on disk already; who misses it reads it from there."""
    try:
        await module.broadcast(message)
    except TcaError as error:
        log.warning("nobody was told of %s: %s", type(message).wire_name, error)
