"""Simulated time: what tick it is, who waits for which time, when to tell everybody.

Pure rules; ``wall`` is seconds of any monotonic clock, handed in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tca_bus import TIME_GRAIN, AwaitTime
from xavier_sim.profile import TICK

HOLD_LIMIT = 10.0
"""Wall seconds for which time stands still for a module: whose awaited time has come and that
has not said yet what it waits for next, or that said that it is at work."""

FORGET_AFTER = 10.0
"""A demand that was not repeated for so many wall seconds is void; they come every second."""

ABSENT_AFTER = 0.5
"""A demand of a module that is not on the bus counts for so many wall seconds."""

NEWS_MOVING = 0.05
"""Wall seconds between announcements of the time while it moves."""

NEWS_STILL = 1.0
"""Wall seconds between announcements of the time while it stands still."""


@dataclass(frozen=True)
class SimClock:
    """Turns ticks into seconds since the epoch; ``start`` is the time of tick 0."""

    start: float

    def time_of(self, tick: int) -> float:
        """The simulated time at a tick."""
        return self.start + tick * TICK

    def moved_to(self, tick: int, at_least: float) -> SimClock:
        """A clock that shows ``at_least`` this time at ``tick``, and never less than this one."""
        return SimClock(self.start + max(0.0, at_least - self.time_of(tick)))


@dataclass
class Demand:
    """One module waits until a simulated time, and makes it move or not.

    ``due`` is set on the wall when that time has come: then time stands still, until the module
    says something else or is ``given_up``.
    """

    module: str
    until: float
    moves: bool
    heard: float
    due: float | None = None
    given_up: bool = False


class Demands:
    """Who waits for simulated time, by incarnation."""

    def __init__(self) -> None:
        self._demands: dict[str, Demand] = {}

    def note(self, demand: AwaitTime, now: float, wall: float) -> bool:
        """A module said what it waits for; true when that time has come already."""
        before = self._demands.pop(demand.incarnation, None)
        if demand.until is None:
            return False
        noted = Demand(demand.module, demand.until, demand.moves, wall)
        has_come = has_reached(now, noted.until)
        if has_come:
            noted.due = wall
            if before is not None and before.until == noted.until and before.due is not None:
                noted.due, noted.given_up = before.due, before.given_up
        self._demands[demand.incarnation] = noted
        return has_come

    def reached(self, now: float, wall: float) -> bool:
        """Mark the demands whose time has come; true when there is a new one."""
        waiting = [demand for demand in self._demands.values() if demand.due is None]
        new = [demand for demand in waiting if has_reached(now, demand.until)]
        for demand in new:
            demand.due = wall
        return bool(new)

    def clean(self, wall: float, present: Callable[[str], bool]) -> list[str]:
        """Forget demands that were not repeated, and those of modules that are gone.

        Returns:
            The modules for which time stood still too long, and which it does not wait for now.
        """
        for incarnation, demand in list(self._demands.items()):
            age = wall - demand.heard
            if age > FORGET_AFTER or (age > ABSENT_AFTER and not present(incarnation)):
                del self._demands[incarnation]
        late = [d for d in self._holding() if d.due is not None and wall - d.due > HOLD_LIMIT]
        for demand in late:
            demand.given_up = True
        return [demand.module for demand in late]

    @property
    def holding(self) -> bool:
        """Whether time has to stand still for a module."""
        return bool(self._holding())

    @property
    def moving(self) -> bool:
        """Whether a module makes time move."""
        return any(demand.moves and demand.due is None for demand in self._demands.values())

    def _holding(self) -> list[Demand]:
        demands = self._demands.values()
        return [demand for demand in demands if demand.due is not None and not demand.given_up]


def has_reached(now: float, when: float) -> bool:
    """Whether a time has come."""
    return when <= now + TIME_GRAIN


class TimeNews:
    """Decides when the simulated time is worth an announcement."""

    def __init__(self) -> None:
        self._told: float | None = None
        self._told_at = float("-inf")
        self._urgent = True

    def hurry(self) -> None:
        """Somebody waits for this very moment."""
        self._urgent = True

    def due_in(self, now: float, wall: float, *, resting: bool = False) -> float:
        """Wall seconds until the time ``now`` should be announced; 0 for at once.

        ``resting`` says that time moves no further for now: then all should know it exactly.
        """
        if self._urgent or (resting and now != self._told):
            return 0.0
        pause = NEWS_MOVING if now != self._told else NEWS_STILL
        return max(0.0, self._told_at + pause - wall)

    def told(self, now: float, wall: float) -> None:
        """The time was announced."""
        self._told, self._told_at, self._urgent = now, wall, False
