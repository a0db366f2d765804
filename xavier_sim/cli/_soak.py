"""``xavier soak``: hours of random errands, with progress, figures and a report."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Protocol

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json, note, show_table
from xavier_sim.cli._worlds import Count, ProfileName
from xavier_sim.floors import DEFAULT_FLOOR
from xavier_sim.snapshots import write_atomically
from xavier_sim.soak import FaultKind, Job, SoakOptions, SoakRun, Spread, Summary
from xavier_sim.soak import report as write_report

LINES = 20
"""Lines of progress that a soak writes where there is no terminal."""

Share = Annotated[float, Parameter(validator=Number(gte=0.0, lte=1.0))]
Positive = Annotated[float, Parameter(validator=Number(gt=0.0))]
AtLeastZero = Annotated[float, Parameter(validator=Number(gte=0.0))]


def soak(
    *,
    hours: Positive,
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    map: str = DEFAULT_FLOOR,  # noqa: A002 - the flag is --map
    profile: ProfileName = "xavier",
    people: Count = 0,
    carts: Count = 0,
    fault: FaultKind | None = None,
    navigator: str = "navigate",
    localizer: str | None = None,
    sigma: Annotated[float, Parameter(validator=Number(gte=0.0, lte=0.2))] = 0.03,
    shut: Share = 0.1,
    door_moves: AtLeastZero = 1.0,
    doors: Annotated[int, Parameter(validator=Number(gte=0, lte=1000))] = 0,
    checkpoint: Path | None = None,
    report: Path | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Send the robot on random errands for hours, and say what came of them.

    World and navigator run in this process, without a network, as fast as they can. The same
    options give the same errands, to the last bit, also when resumed.

    Args:
        hours: Simulated hours to go on for.
        seed: Seed of everything random, 0 or more.
        map: Floor plan: the name of a floor that comes with it, or a YAML file.
        profile: The robot: Xavier as a rule, on its bad days, or a robot of today with a lidar.
        people: How many people walk the corridors and stand about in them.
        carts: How many carts stand in the corridors, now here, now there.
        fault: What is wrong with the robot, or goes wrong again and again.
        navigator: Name of an installed navigator, or module:factory.
        localizer: What tells the navigator where it is, if it has a choice: for navigate
            "particles" or "odometry".
        sigma: Standard deviation of the errors in the navigator's map, metres.
        shut: Share of the time that a door is shut, 0 to 1.
        door_moves: How often an hour somebody opens or shuts each door.
        doors: Go into every room and out again so many times, instead of anywhere at random.
        checkpoint: File to keep the soak in; if it is there, go on with it.
        report: File for a page of HTML with all figures, plots, and every job that failed.
        flags: Shared flags; no bus is needed.
    """
    options = SoakOptions(
        seed=seed,
        floor=map,
        profile=profile,
        people=people,
        carts=carts,
        fault=fault,
        navigator=navigator,
        navigator_options={"localizer": localizer} if localizer else {},
        survey_sigma=sigma,
        shut_share=shut,
        door_moves_per_hour=door_moves,
        doors_in_and_out=doors,
    )
    run = SoakRun(options, checkpoint)
    if run.resumed:
        note(f"going on after {run.soak.seconds / 3600:.2f} hours, from {checkpoint}")
    with _progress(hours) as progress:
        for job in run.jobs(hours):
            progress.tell(job, run)
    summary = run.summary()
    if report is not None:
        write_atomically(report, write_report(summary, run.soak.course.tally))
    if flags.json:
        emit_json(summary)
    else:
        show_summary(summary)


class Progress(Protocol):
    """Tells how far a soak has come."""

    def tell(self, job: Job, run: SoakRun) -> None:
        """A job has ended."""
        ...


class Lines:
    """A line now and then."""

    def __init__(self, hours: float) -> None:
        self._step = hours * 3600.0 / LINES
        self._next = self._step

    def tell(self, job: Job, run: SoakRun) -> None:
        """Write a line when another twentieth is done."""
        del job
        if run.soak.seconds >= self._next:
            self._next = run.soak.seconds + self._step
            note(_standing(run))


@contextmanager
def _progress(hours: float) -> Iterator[Progress]:
    """A bar on a terminal, lines elsewhere, both on standard error."""
    from rich.console import Console  # noqa: PLC0415 - only for this command
    from rich.progress import Progress as Bars  # noqa: PLC0415 - same
    from rich.progress import TextColumn, TimeRemainingColumn  # noqa: PLC0415 - same

    console = Console(stderr=True)
    if not console.is_terminal:
        yield Lines(hours)
        return
    columns = (
        *Bars.get_default_columns()[:3],
        TimeRemainingColumn(),
        TextColumn("{task.fields[at]}"),
    )
    with Bars(*columns, console=console) as bars:
        task = bars.add_task("soaking", total=hours * 3600.0, at="")
        yield _Bar(lambda seconds, at: bars.update(task, completed=seconds, at=at))


class _Bar:
    def __init__(self, update: _Update) -> None:
        self._update = update

    def tell(self, job: Job, run: SoakRun) -> None:
        del job
        self._update(run.soak.seconds, _standing(run))


class _Update(Protocol):
    def __call__(self, seconds: float, at: str, /) -> object: ...


def _standing(run: SoakRun) -> str:
    """Where a soak stands, in a line."""
    soak, jobs = run.soak, run.soak.course.tally.jobs
    arrived = sum(job.arrived for job in jobs)
    kilometres = sum(job.metres for job in jobs) / 1000.0
    pace = soak.seconds / max(run.cost.wall, 1e-9)
    return (
        f"{soak.seconds / 3600:.2f} h, {kilometres:.2f} km, {arrived} of {len(jobs)} jobs "
        f"completed, {pace:.0f} x real time"
    )


def show_summary(summary: Summary) -> None:
    """Print the figures as a table."""
    show_table(["what", "figure"], _rows(summary))
    if summary.reasons:
        emit("")
        show_table(["not completed because", "jobs"], list(summary.reasons.items()))


def _rows(summary: Summary) -> list[tuple[str, object]]:
    rates = {"reachable": summary.reachable, "unreachable": summary.unreachable}
    rates["changing"] = summary.changing
    spreads = {
        "driving speed, m/s": summary.driving_speed,
        "position error, m": summary.position_error,
        "arrival error, m": summary.arrival_error,
        "job, s": summary.job_seconds,
    }
    return [
        ("hours", f"{summary.hours:.2f}"),
        ("km", f"{summary.km:.3f}"),
        ("jobs", summary.jobs),
        ("completed", summary.completed),
        *((f"{name} goals: right", f"{rate.right} of {rate.jobs}") for name, rate in rates.items()),
        ("false arrivals", summary.false_arrivals),
        ("bumps", summary.bumps),
        ("people run into", summary.people_hit),
        ("recoveries per km", f"{summary.recoveries_per_km:.2f}"),
        ("rescues", summary.rescues),
        ("median speed, m/s", summary.median_speed),
        *((name, _spread(spread)) for name, spread in spreads.items()),
        ("real-time factor", f"{summary.real_time_factor:.0f}"),
        ("the same by processor time", f"{summary.cpu_time_factor:.0f}"),
        ("memory, MB", f"{summary.memory_mb[0]:.0f}, at the end {summary.memory_mb[1]:.0f}"),
    ]


def _spread(spread: Spread) -> str:
    if spread.median is None:
        return ""
    return f"{spread.median:g} (90 % {spread.p90:g}, 99 % {spread.p99:g}, most {spread.most:g})"
