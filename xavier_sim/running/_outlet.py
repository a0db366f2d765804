"""What the robot says: to all on the bus, and to whoever records it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import Protocol

from pydantic import BaseModel

from tca_bus import Broadcast, Module
from xavier_sim.messages import Sensors, Standing, TrueLocation


class Witness(Protocol):
    """Is told all that the robot senses, does and says, in the order in which it happens."""

    async def sense(
        self, sensors: Sensors, truth: TrueLocation, standing: Sequence[Standing]
    ) -> None:
        """A tick has begun: once for each, before others hear of it; may hold the robot up.

        Args:
            sensors: what the robot senses.
            truth: where it really is.
            standing: who and what stands about, always in the same order.
        """

    def note(self, message: BaseModel, time: float) -> None:
        """Something else was said or done at a simulated time, seconds since the epoch."""


class Outlet:
    """Tells the bus, and the witness if there is one.

    Args:
        module: that speaks.
        witness: who records it.
        now: gives the simulated time, seconds since the epoch.
        before: awaited before all on the bus are told.
    """

    def __init__(
        self,
        module: Module,
        witness: Witness | None,
        now: Callable[[], float],
        before: Callable[[], Awaitable[None]],
    ) -> None:
        self._module, self._witness, self._now, self._before = module, witness, now, before

    async def broadcast(self, message: Broadcast) -> None:
        """Tell all who listen."""
        self.note(message)
        await self._before()
        await self._module.broadcast(message)

    def note(self, message: BaseModel) -> None:
        """Let the witness know of something that not all hear."""
        if self._witness is not None:
            self._witness.note(message, self._now())
