"""Wall time or simulated time behind one interface."""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import AbstractAsyncContextManager


class Clock(ABC):
    """The time of the world, in seconds since the epoch."""

    @abstractmethod
    def now(self) -> float:
        """The time."""

    @abstractmethod
    async def sleep_until(self, when: float) -> None:
        """Wait actively until ``when``: in lockstep this makes simulated time move."""

    @abstractmethod
    async def watch_until(self, when: float) -> None:
        """Wait passively until ``when``: does not make simulated time move."""

    @abstractmethod
    def timeout(self, seconds: float) -> AbstractAsyncContextManager[None]:
        """Raise TimeoutError from the block after ``seconds`` of this clock."""

    @abstractmethod
    async def wait_ready(self, timeout: float) -> None:  # noqa: ASYNC109
        """Wait until the time is known, at most ``timeout`` wall seconds."""

    async def sleep(self, seconds: float) -> None:
        """Wait actively for ``seconds``."""
        await self.sleep_until(self.now() + seconds)
