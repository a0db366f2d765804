"""What a soak has come to, in figures: the document that ``xavier soak --json`` prints."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pydantic import BaseModel, ConfigDict

from xavier_sim.soak._cost import Cost
from xavier_sim.soak._door_rates import DoorRates, door_rates
from xavier_sim.soak._explaining import explain
from xavier_sim.soak._histogram import Histogram
from xavier_sim.soak._jobs import Job, median_speed, outcomes
from xavier_sim.soak._loading import settings_of
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._postmortem import PostMortem
from xavier_sim.soak._tally import Tally
from xavier_sim.soak._way import Way


class Rate(BaseModel):
    """How many of how many jobs; ``share`` is None of none."""

    model_config = ConfigDict(frozen=True)

    jobs: int
    right: int
    share: float | None


class Spread(BaseModel):
    """A distribution: median, the 90th and 99th percentile, the greatest value."""

    model_config = ConfigDict(frozen=True)

    median: float | None
    p90: float | None
    p99: float | None
    most: float | None


class Figures(BaseModel):
    """The figures of one soak, or of several together.

    ``completed`` are the jobs whose robot truly arrived; all others are ``failed``, with their
    ``reasons``: those that the navigator gave, and ``elsewhere`` for false arrivals.
    ``reachable`` are jobs to which the doors left a way at all times, right when completed;
    ``unreachable`` those to which they left none, right when given up for that; ``changing`` the
    rest, right either way. ``bumps`` are all contacts; ``people_hit`` those in which the robot came
    towards somebody faster than 0.1 m/s, ``walked_into`` those in which somebody came to it.
    ``faults`` is how often the fault of the options struck, once if it is one that lasts. ``doors``
    are there for errands in and out of every room.

    Times are simulated seconds but for ``wall_seconds`` and ``cpu_seconds``; ``real_time_factor``
    is by the wall, ``cpu_time_factor`` by processor time. Distances are metres, speeds metres per
    second, memory megabytes at its peak. Where there are several the times are added up, as if one
    had come after the other.
    """

    model_config = ConfigDict(frozen=True)

    hours: float
    km: float
    jobs: int
    completed: int
    failed: int
    reasons: dict[str, int]
    false_arrivals: int
    bumps: int
    recoveries_per_km: float
    real_time_factor: float
    cpu_time_factor: float
    reachable: Rate
    unreachable: Rate
    changing: Rate
    people_hit: int
    walked_into: int
    rescues: int
    door_moves: int
    faults: int
    median_speed: float | None
    driving_speed: Spread
    position_error: Spread
    arrival_error: Spread
    job_seconds: Spread
    wall_seconds: float
    cpu_seconds: float
    memory_mb: tuple[float, float]
    doors: DoorRates | None = None


class Explained(BaseModel):
    """A job that went wrong: when, from where to where, how it ended, and why.

    ``began`` is in simulated seconds; ``why`` is a sentence, made from the ``facts``.
    """

    model_config = ConfigDict(frozen=True)

    number: int
    began: float
    start: str | None
    goal: str
    outcome: str
    why: str
    facts: PostMortem


class Summary(Figures):
    """The figures of a soak, its options, and each of its failures explained.

    ``navigator_settings`` are what the navigator was made with, its own defaults among them.
    """

    options: SoakOptions
    navigator_settings: dict[str, str]
    failures: tuple[Explained, ...] = ()


class Totals(BaseModel):
    """The figures of several soaks that differ in their seeds: together, and of each."""

    model_config = ConfigDict(frozen=True)

    total: Figures
    seeds: tuple[Summary, ...]


@dataclass(frozen=True)
class Outcome:
    """What a soak came to in so many simulated seconds, and at what cost."""

    options: SoakOptions
    tally: Tally
    seconds: float
    cost: Cost

    def summary(self) -> Summary:
        """Its figures."""
        figures = _figures(self.tally, self.seconds, self.cost, tries_doors=self.tries_doors)
        return Summary(
            **dict(figures),
            options=self.options,
            navigator_settings=self.navigator_settings,
            failures=self.failures(),
        )

    @property
    def tries_doors(self) -> bool:
        """Whether its errands went in and out of every room."""
        return self.options.doors_in_and_out > 0

    @property
    def navigator_settings(self) -> dict[str, str]:
        """What the navigator was made with."""
        return settings_of(self.options.navigator, self.options.navigator_options)

    def failures(self) -> tuple[Explained, ...]:
        """Why each job went wrong that did, but for those kept before there were post-mortems."""
        return tuple(one for job in self.tally.jobs if (one := _explained(job)))


def together(outcomes: Sequence[Outcome]) -> tuple[Figures, Tally]:
    """The figures of several soaks as if they were one, and all that was counted in them."""
    tally, cost = Tally(), Cost()
    for one in outcomes:
        tally.add_all(one.tally)
        cost += one.cost
    seconds = sum(one.seconds for one in outcomes)
    tries_doors = any(one.tries_doors for one in outcomes)
    return _figures(tally, seconds, cost, tries_doors=tries_doors), tally


def _figures(tally: Tally, seconds: float, cost: Cost, *, tries_doors: bool) -> Figures:
    jobs, completed = tally.jobs, [job for job in tally.jobs if job.arrived]
    km = sum(job.metres for job in jobs) / 1000.0
    return Figures(
        hours=round(seconds / 3600.0, 4),
        km=round(km, 4),
        jobs=len(jobs),
        completed=len(completed),
        failed=len(jobs) - len(completed),
        reasons=outcomes(jobs),
        false_arrivals=sum(job.false_arrival for job in jobs),
        bumps=sum(job.bumps for job in jobs),
        recoveries_per_km=round(sum(job.recoveries for job in jobs) / max(km, 1e-3), 3),
        real_time_factor=round(seconds / max(cost.wall, 1e-9), 1),
        cpu_time_factor=round(seconds / max(cost.cpu, 1e-9), 1),
        reachable=_rate(jobs, Way.OPEN),
        unreachable=_rate(jobs, Way.SHUT),
        changing=_rate(jobs, Way.CHANGING),
        people_hit=sum(job.people_hit for job in jobs),
        walked_into=sum(job.walked_into for job in jobs),
        rescues=tally.rescues,
        door_moves=tally.door_moves,
        faults=tally.faults,
        median_speed=median_speed(jobs),
        driving_speed=_spread_of(tally.speeds),
        position_error=_spread_of(tally.errors),
        arrival_error=_spread([job.off for job in completed]),
        job_seconds=_spread([job.seconds for job in completed]),
        wall_seconds=round(cost.wall, 1),
        cpu_seconds=round(cost.cpu, 1),
        memory_mb=(round(cost.memory_early, 1), round(cost.memory, 1)),
        doors=door_rates(jobs) if tries_doors else None,
    )


def _explained(job: Job) -> Explained | None:
    if job.post_mortem is None:
        return None
    return Explained(
        number=job.number,
        began=job.began,
        start=job.start,
        goal=job.goal,
        outcome=job.outcome,
        why=explain(job, job.post_mortem),
        facts=job.post_mortem,
    )


def _rate(jobs: Iterable[Job], way: Way) -> Rate:
    met = [job for job in jobs if job.way is way]
    right = sum(job.arrived or job.refused_rightly for job in met)
    return Rate(jobs=len(met), right=right, share=round(right / len(met), 5) if met else None)


def _spread(values: Sequence[float]) -> Spread:
    if len(values) < 2:
        one = values[0] if values else None
        return Spread(median=one, p90=one, p99=one, most=one)
    cuts = statistics.quantiles(values, n=100, method="inclusive")
    return Spread(
        median=_rounded(cuts[49]), p90=_rounded(cuts[89]), p99=_rounded(cuts[98]), most=max(values)
    )


def _spread_of(histogram: Histogram) -> Spread:
    median, p90, p99 = (_rounded(histogram.quantile(share)) for share in (0.5, 0.9, 0.99))
    most = _rounded(histogram.most) if histogram.total else None
    return Spread(median=median, p90=p90, p99=p99, most=most)


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
