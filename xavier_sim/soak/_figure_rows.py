"""Figures as rows of a table: one for each figure, with a cell for each soak."""

from __future__ import annotations

from collections.abc import Sequence

from xavier_sim.soak._door_rates import DoorRates
from xavier_sim.soak._summary import Figures, Rate, Spread

STRUCK = "times that the fault struck"
"""A row that there is only where one did."""


def figure_rows(columns: Sequence[Figures]) -> list[tuple[str, ...]]:
    """Every figure with its name, and what it is in each of the columns."""
    cells = [_cells(one) for one in columns]
    rows = [(name, *(one[name] for one in cells)) for name in (cells[0] if cells else ())]
    rows = [row for row in rows if row[0] != STRUCK or any(one.faults for one in columns)]
    return rows + _door_rows(columns)


def _door_rows(columns: Sequence[Figures]) -> list[tuple[str, ...]]:
    """What came of the drives through doors, where errands were those."""
    if not any(one.doors for one in columns):
        return []
    names = (
        "drives through doors that were open",
        "of those: stuck, there or elsewhere on the drive",
        "of the stuck: recovered and arrived",
        "of all: given up",
    )
    return list(zip(names, *(_door_cells(one.doors) for one in columns), strict=True))


def _door_cells(doors: DoorRates | None) -> tuple[str, ...]:
    if doors is None:
        return ("",) * 4
    return (
        str(doors.drives),
        _part(doors.stuck, doors.drives, doors.stuck_share),
        _part(doors.recovered, doors.stuck, doors.recovered_share),
        _part(doors.given_up, doors.drives, doors.given_up_share),
    )


def reason_rows(columns: Sequence[Figures]) -> list[tuple[str, ...]]:
    """Every reason for which jobs were not completed, the most frequent first, with counts."""
    names = dict.fromkeys(name for one in columns for name in one.reasons)
    frequent = sorted(names, key=lambda name: -sum(one.reasons.get(name, 0) for one in columns))
    return [(name, *(str(one.reasons.get(name, 0)) for one in columns)) for name in frequent]


def _cells(figures: Figures) -> dict[str, str]:
    early, late = figures.memory_mb
    return {
        "hours": f"{figures.hours:.2f}",
        "km": f"{figures.km:.3f}",
        "jobs": str(figures.jobs),
        "completed": str(figures.completed),
        "goals with an open way: completed": _rate(figures.reachable),
        "goals behind closed doors: given up for that": _rate(figures.unreachable),
        "goals whose way changed: either": _rate(figures.changing),
        "false arrivals": str(figures.false_arrivals),
        "bumps": str(figures.bumps),
        "people run into above 0.1 m/s": str(figures.people_hit),
        "people who walked into the robot": str(figures.walked_into),
        "recoveries per km": f"{figures.recoveries_per_km:.2f}",
        "rescues by people": str(figures.rescues),
        STRUCK: str(figures.faults),
        "median speed of a job, m/s": _shown(figures.median_speed),
        "speed while driving, m/s": _spread(figures.driving_speed),
        "distance between belief and truth, m": _spread(figures.position_error),
        "off the place at arrival, m": _spread(figures.arrival_error),
        "time of a job, s": _spread(figures.job_seconds),
        "real-time factor": f"{figures.real_time_factor:.0f}",
        "the same by processor time": f"{figures.cpu_time_factor:.0f}",
        "memory after an hour and at the end, MB": f"{early:.0f}, {late:.0f}",
    }


def _rate(rate: Rate) -> str:
    return _part(rate.right, rate.jobs, rate.share)


def _part(some: int, of_all: int, share: float | None) -> str:
    shown = f" ({100 * share:.2f} %)" if share is not None else ""
    return f"{some} of {of_all}{shown}"


def _spread(spread: Spread) -> str:
    if spread.median is None:
        return ""
    return f"{spread.median:g} (90 % {spread.p90:g}, 99 % {spread.p99:g}, most {spread.most:g})"


def _shown(value: float | None) -> str:
    return "" if value is None else f"{value:g}"
