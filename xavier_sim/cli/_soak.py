"""``xavier soak``: hours of random errands, with progress, figures and a report."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus import ConfigError
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json, note, show_table
from xavier_sim.cli._soak_crew import Task, run_crew
from xavier_sim.cli._soak_flags import DEFAULT_ERRANDS, ErrandFlags, Hours, parse_seeds
from xavier_sim.cli._soak_progress import progress_of
from xavier_sim.snapshots import write_atomically
from xavier_sim.soak import (
    Figures,
    Outcome,
    SoakRun,
    Totals,
    figure_rows,
    reason_rows,
    together,
)
from xavier_sim.soak import report as write_report

MOST_FAILURES = 10
"""Failures that are explained on the terminal; report and document have all."""


def soak(
    *,
    hours: Hours,
    seed: Annotated[int | None, Parameter(validator=Number(gte=0))] = None,
    seeds: str | None = None,
    jobs: Annotated[int | None, Parameter(validator=Number(gte=1))] = None,
    checkpoint: Path | None = None,
    report: Path | None = None,
    errands: ErrandFlags = DEFAULT_ERRANDS,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Send the robot on random errands for hours, and say what came of them.

    World and navigator run in one process, without a network, as fast as they can. The same
    options give the same errands, to the last bit, also when resumed.

    Args:
        hours: Simulated hours to go on for.
        seed: Seed of everything random, 0 or more; 0 when not given.
        seeds: Several of them, as in "1,2,3": a soak of so many hours with each, side by side.
        jobs: How many seeds at a time; as many as there are cores when not given.
        checkpoint: File to keep the soak in; if it is there, go on with it. With --seeds there is
            one for each, with the seed after its name.
        report: File for a page of HTML with all figures, plots, and every job that failed.
        errands: What errands they are.
        flags: Shared flags; no bus is needed.
    """
    for flag, file in (("--report", report), ("--checkpoint", checkpoint)):
        if file is not None:
            _check_file(flag, file)
    tasks = [
        Task(errands.options(one), hours, _file(checkpoint, one if seeds else None))
        for one in _seeds(seed, seeds)
    ]
    outcomes = _run(tasks, jobs or _cores())
    if report is not None:
        write_atomically(report, write_report(outcomes))
    _show(outcomes, flags)


def _check_file(flag: str, file: Path) -> None:
    """Find out before the hours are soaked whether what comes of them can be written.

    Raises:
        ConfigError: it cannot.
    """
    folder = file.parent
    if file.is_dir() or not folder.is_dir() or not os.access(folder, os.W_OK):
        raise ConfigError(flag, str(file), "a file in a folder that can be written to")


def _cores() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _seeds(seed: int | None, seeds: str | None) -> list[int]:
    if seeds is None:
        return [seed or 0]
    if seed is not None:
        raise ConfigError("--seed", seed, "none beside --seeds")
    return parse_seeds(seeds)


def _file(checkpoint: Path | None, seed: int | None) -> Path | None:
    if checkpoint is None or seed is None:
        return checkpoint
    return checkpoint.with_stem(f"{checkpoint.stem}-{seed}")


def _run(tasks: Sequence[Task], jobs: int) -> list[Outcome]:
    hours = tasks[0].hours
    with progress_of([task.options.seed for task in tasks], hours) as progress:
        if len(tasks) > 1:
            return run_crew(tasks, jobs=jobs, tell=progress.tell)
        run = SoakRun(tasks[0].options, tasks[0].checkpoint)
        if run.resumed:
            kept = run.soak.seconds / 3600
            note(f"going on after {kept:.2f} hours, from {tasks[0].checkpoint}")
        for _ in run.jobs(hours):
            progress.tell(run.standing())
    return [run.outcome()]


def _show(outcomes: Sequence[Outcome], flags: BusFlags) -> None:
    summaries = [outcome.summary() for outcome in outcomes]
    if len(summaries) == 1:
        names, columns = ["figure"], list[Figures](summaries)
    else:
        total, _ = together(outcomes)
        names = [f"seed {one.options.seed}" for one in summaries] + ["all"]
        columns = [*summaries, total]
    if not flags.json:
        _show_tables(names, columns)
        _show_failures(outcomes)
    elif len(summaries) == 1:
        emit_json(summaries[0])
    else:
        emit_json(Totals(total=columns[-1], seeds=tuple(summaries)))


def _show_failures(outcomes: Sequence[Outcome]) -> None:
    failures = [(one.options.seed, why) for one in outcomes for why in one.failures()]
    if failures:
        emit("")
    for seed, one in failures[:MOST_FAILURES]:
        whose = f"seed {seed}, " if len(outcomes) > 1 else ""
        way = f"{one.start or 'nowhere'} to {one.goal}"
        emit(f"{whose}job {one.number} at {one.began / 3600:.2f} h, {way}: {one.why}")
    if len(failures) > MOST_FAILURES:
        emit(f"... and {len(failures) - MOST_FAILURES} more")


def _show_tables(names: Sequence[str], columns: Sequence[Figures]) -> None:
    show_table(["what", *names], figure_rows(columns))
    reasons = reason_rows(columns)
    if reasons:
        emit("")
        heads = ["jobs"] if len(names) == 1 else names
        show_table(["not completed because", *heads], reasons)
