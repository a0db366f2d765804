"""The plots of a report: success and position error over time, reasons, times, and places."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence

from xavier_sim.floors import build_geometry, load_floor
from xavier_sim.soak._charts import Axis, Point, bars, columns, curves, plan_view, points
from xavier_sim.soak._jobs import Job
from xavier_sim.soak._summary import Outcome, together
from xavier_sim.soak._way import Way

WINDOW = 50
"""Jobs over which running figures are taken."""

SLOTS = 30
"""Columns of the histogram of times."""


def plots(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """All of them, of soaks that differ in their seeds."""
    figures, tally = together(outcomes)
    yield _success(outcomes)
    yield bars("Jobs that were not completed, by reason", figures.reasons)
    yield _error_over_time(outcomes)
    yield _error_shares(outcomes)
    yield _times(tally.jobs)
    yield _ways(tally.jobs)
    yield _places(outcomes[0].options.floor, tally.jobs)


def _by_seed(outcomes: Sequence[Outcome]) -> Mapping[str, Outcome]:
    return {f"seed {one.options.seed}": one for one in outcomes}


def _success(outcomes: Sequence[Outcome]) -> str:
    lines = {name: _running_share(one.tally.jobs) for name, one in _by_seed(outcomes).items()}
    x = Axis.over("hours", (hour for line in lines.values() for hour, _ in line))
    lowest = min((share for line in lines.values() for _, share in line), default=90.0)
    y = Axis("% completed", min(90.0, 10.0 * (lowest // 10.0)), 100.0)
    return curves(f"Success where there was a way, last {WINDOW} jobs", x, y, lines)


def _running_share(jobs: Iterable[Job]) -> list[Point]:
    met = [job for job in jobs if job.way is Way.OPEN]
    return _running(met, [100.0 * job.arrived for job in met])


def _error_over_time(outcomes: Sequence[Outcome]) -> str:
    lines = {
        name: _running(one.tally.jobs, [job.mean_off for job in one.tally.jobs])
        for name, one in _by_seed(outcomes).items()
    }
    x = Axis.over("hours", (hour for line in lines.values() for hour, _ in line))
    y = Axis.over("metres", [*(mean for line in lines.values() for _, mean in line), 0.05])
    return curves(f"Distance between belief and truth, mean of {WINDOW} jobs", x, y, lines)


def _running(jobs: Sequence[Job], values: Sequence[float]) -> list[Point]:
    """The mean of the last values at the end of each job, against hours."""
    window, line = deque[float](maxlen=WINDOW), list[Point]()
    for job, value in zip(jobs, values, strict=True):
        window.append(value)
        line.append(((job.began + job.seconds) / 3600.0, sum(window) / len(window)))
    return line


def _error_shares(outcomes: Sequence[Outcome]) -> str:
    errors = {name: one.tally.errors for name, one in _by_seed(outcomes).items()}
    lines = {
        name: [(error, 100.0 * share) for error, share in one.shares()]
        for name, one in errors.items()
    }
    x = Axis.over("metres", [one.quantile(0.999) or 0.1 for one in errors.values()])
    y = Axis("% of the time below", 0.0, 100.0)
    return curves("Distance between belief and truth, distribution", x, y, lines)


def _times(jobs: Sequence[Job]) -> str:
    seconds = [job.seconds for job in jobs if job.arrived]
    x = Axis.over("seconds", seconds or [1.0])
    width = (x.high - x.low) / SLOTS
    counts = [0] * SLOTS
    for value in seconds:
        counts[min(SLOTS - 1, int(value / width))] += 1
    slots = [(width * slot, width * (slot + 1), float(count)) for slot, count in enumerate(counts)]
    return columns("Time of a completed job", x, Axis.over("jobs", [*counts, 1]), slots)


def _ways(jobs: Sequence[Job]) -> str:
    groups = {
        "arrived": [(job.metres, job.seconds) for job in jobs if job.arrived],
        "not": [(job.metres, job.seconds) for job in jobs if not job.arrived],
    }
    x = Axis.over("metres driven", [job.metres for job in jobs] or [1.0])
    y = Axis.over("seconds", [job.seconds for job in jobs] or [1.0])
    return points("Way and time of each job", x, y, groups)


def _places(floor: str, jobs: Sequence[Job]) -> str:
    walls = build_geometry(load_floor(floor)).walls.tolist()
    missed = [job for job in jobs if not job.arrived]
    groups = {
        "given up rightly": [(job.x, job.y) for job in missed if job.refused_rightly],
        "failed": [(job.x, job.y) for job in missed if not job.refused_rightly],
    }
    return plan_view("Where jobs ended that were not completed", walls, groups)
