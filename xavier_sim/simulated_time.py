"""Simulated time: what tick it is, who waits for which time, when to tell everybody.

Pure rules; ``wall`` is seconds of any monotonic clock, handed in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from xavier_sim.profile import TICK

WAKE_GRACE = 0.25
"""Wall seconds that time stands still for a module whose awaited time has come, until it says
what it waits for next."""

FORGET_AFTER = 3.0
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
    """One module waits until a simulated time; ``due`` is set on the wall when it has come."""

    until: float
    heard: float
    due: float | None = None


class Demands:
    """Who waits actively for simulated time, by incarnation."""

    def __init__(self) -> None:
        self._demands: dict[str, Demand] = {}

    def note(self, incarnation: str, until: float | None, now: float, wall: float) -> bool:
        """A module said what it waits for; true when that time has come already."""
        self._demands.pop(incarnation, None)
        if until is None or until <= now:
            return until is not None
        self._demands[incarnation] = Demand(until, wall)
        return False

    def reached(self, now: float, wall: float) -> bool:
        """Mark the demands whose time has come; true when there is a new one."""
        new = [d for d in self._demands.values() if d.due is None and d.until <= now + TICK / 1e6]
        for demand in new:
            demand.due = wall
        return bool(new)

    def clean(self, wall: float, present: Callable[[str], bool]) -> None:
        """Forget demands that are void: not repeated, of modules gone, or met long enough ago."""
        for incarnation, demand in list(self._demands.items()):
            age = wall - demand.heard
            gone = age > ABSENT_AFTER and not present(incarnation)
            met = demand.due is not None and wall - demand.due > WAKE_GRACE
            if age > FORGET_AFTER or gone or met:
                del self._demands[incarnation]

    @property
    def waking(self) -> bool:
        """Whether a module whose time has come has still to say what it waits for next."""
        return any(demand.due is not None for demand in self._demands.values())

    @property
    def any(self) -> bool:
        """Whether somebody waits for a time to come."""
        return any(demand.due is None for demand in self._demands.values())


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
