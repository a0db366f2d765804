"""One errand of the soak and how it ended, judged by the truth."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Iterable

from pydantic import TypeAdapter
from pydantic.dataclasses import dataclass

from xavier_sim.soak._postmortem import PostMortem
from xavier_sim.soak._way import Way

ASTRAY = 0.5
"""Metres from the place of a room beyond which a robot that reports arrival is elsewhere."""

TIME_LIMIT = 1200.0
"""Simulated seconds after which a drive that does not end is given up."""

ENDLESS = "endless"
"""The reason of a drive that was given up at the time limit."""

BLOCKED_REASONS = frozenset({"door_blocked", "corridor_blocked", "no_route"})
"""What a drive may fail with where the doors left no way for some of its time."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Job:
    """One errand: metres, seconds, and what came of it.

    ``reason`` is None for a reported arrival, ``off`` then the metres from the place of the room;
    ``x`` and ``y`` is where the robot really was at the end. ``mean_off``, ``worst_off`` and
    ``last_off`` are the mean, the greatest and the last distance between belief and truth on the
    way. ``people_hit`` counts
    contacts in which the robot came towards somebody faster than 0.1 m/s, ``walked_into`` those in
    which it did not: somebody came to it. ``bumps`` are all contacts. ``post_mortem`` has the facts
    about one that `went_wrong`.

    No model, which would take four times the memory: a soak of days keeps all of them.
    """

    number: int
    began: float
    start: str | None
    goal: str
    way: Way
    reason: str | None
    seconds: float
    metres: float
    x: float
    y: float
    off: float
    mean_off: float
    worst_off: float
    last_off: float | None = None
    confidence: float
    recoveries: int
    bumps: int
    people_hit: int = 0
    walked_into: int = 0
    post_mortem: PostMortem | None = None

    @property
    def arrived(self) -> bool:
        """Whether the navigator said so and was right."""
        return self.reason is None and self.off <= ASTRAY

    @property
    def false_arrival(self) -> bool:
        """Whether the navigator said that it had arrived and was elsewhere."""
        return self.reason is None and self.off > ASTRAY

    @property
    def refused_rightly(self) -> bool:
        """Whether a drive failed for the doors, and they did leave no way for a time."""
        return self.way is not Way.OPEN and self.reason in BLOCKED_REASONS

    @property
    def went_wrong(self) -> bool:
        """Whether it neither arrived nor was right to give up."""
        return not self.arrived and not self.refused_rightly

    @property
    def outcome(self) -> str:
        """``arrived``, ``elsewhere``, or the reason of the failure."""
        return self.reason or ("arrived" if self.arrived else "elsewhere")


JOBS: TypeAdapter[list[Job]] = TypeAdapter(list[Job])
"""To and from what JSON holds."""


def outcomes(jobs: Iterable[Job]) -> dict[str, int]:
    """How many jobs ended in each way but for arrivals, most frequent first."""
    return dict(Counter(job.outcome for job in jobs if not job.arrived).most_common())


def median_speed(jobs: Iterable[Job]) -> float | None:
    """The median over arrivals of metres driven by seconds taken, waiting included."""
    speeds = [job.metres / job.seconds for job in jobs if job.arrived and job.metres > 1.0]
    return round(statistics.median(speeds), 3) if speeds else None
