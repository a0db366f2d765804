"""What is driven over the bus: a robot in a world, or the recording of one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from tca_bus import Module
from xavier_sim.messages import Sensors, Standing, TrueLocation
from xavier_sim.robot import Reading
from xavier_sim.running._outlet import Outlet
from xavier_sim.running._reflex import Reflex
from xavier_sim.snapshots import Saved


class Desk(Protocol):
    """What a plant answers beside driving."""

    async def tell_news(self) -> None:
        """Broadcast what the last tick brought that others should hear."""


class Plant(Protocol):
    """Something with wheels and sensors that goes on by control ticks.

    ``speed`` is simulated seconds per wall second, None for lockstep with the driver;
    ``tick_limit`` a tick that it may not pass before it was kept; ``patience`` wall seconds for
    which it stands still at most for what it has `awaited`.
    """

    speed: float | None
    tick_limit: int
    patience: float

    @property
    def tick(self) -> int:
        """The control tick that it is at."""

    @property
    def now(self) -> float:
        """Simulated seconds since the epoch."""

    @property
    def reading(self) -> Reading:
        """What it senses at this tick."""

    @property
    def must_save(self) -> bool:
        """Whether it has to be kept before the next tick."""

    @property
    def is_over(self) -> bool:
        """Whether this tick is its last."""

    def attach(self, reflex: Reflex) -> None:
        """Let the base's reflex sense each reading from this one on, or go on from where it was."""

    async def advance(self, speed: float, turn_rate: float) -> Reading:
        """Go on by a tick under a command in m/s and rad/s, and sense."""

    def may_tick(
        self, *, driven: bool, answered: bool, busy: bool, moving: bool, holding: bool
    ) -> bool:
        """Whether it may go on by a tick in lockstep, or is at its end; as `may_tick`."""

    def awaited(self, *, driven: bool, busy: bool) -> str | None:
        """What it stands still for in lockstep, beside the answer of a driver that is there."""

    def wake_by(self, wake: Callable[[], None]) -> None:
        """Be told whom to wake when something else than a message may let it tick."""

    def saved(self, *, stopped: bool = False) -> Saved | None:
        """What to keep of it now, or when it goes on no more; None for nothing."""

    def sensors(self) -> Sensors:
        """The reading of this tick as a message."""

    def true_location(self) -> TrueLocation:
        """Where it really is."""

    def standing(self) -> list[Standing]:
        """Who and what stands about, always in the same order; nothing where nobody knows."""

    def open_desk(self, module: Module, outlet: Outlet, changed: Callable[[], None]) -> Desk:
        """Serve what is asked of it beside driving; ``changed`` is called after a change."""
