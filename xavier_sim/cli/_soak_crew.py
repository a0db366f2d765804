"""Several soaks side by side, each in a process of its own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import TypeAlias

from tca_bus import TcaError
from xavier_sim.soak import Outcome, SoakOptions, SoakRun, Standing


class SoakEndedError(TcaError):
    """The process that ran the soak of a ``seed`` was ended from outside."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        super().__init__(f"the process of the soak with seed {seed} was ended from outside")


@dataclass(frozen=True)
class Task:
    """A soak to run for so many simulated ``hours``, kept in a file if there is one."""

    options: SoakOptions
    hours: float
    checkpoint: Path | None


_ENDED = None
"""What the queue says of a process that has nothing more to tell."""

News: TypeAlias = "Queue[Standing | None]"


def run_crew(
    tasks: Sequence[Task], *, jobs: int, tell: Callable[[Standing], None]
) -> list[Outcome]:
    """Run soaks, some at a time, and give what they came to in their order.

    Args:
        tasks: what to run.
        jobs: how many at a time.
        tell: is told how far each has come.

    Raises:
        TcaError: as of `SoakRun`, of the first that failed; the others went on to their ends.
        SoakEndedError: a process was ended from outside.
        KeyboardInterrupt: this one was; the others ended and kept their soaks after the job that
            they were at.
    """
    context = multiprocessing.get_context("spawn")
    news, halt = context.Queue(), context.Event()
    workers = min(jobs, len(tasks))
    with ProcessPoolExecutor(workers, context, initializer=_begin, initargs=(news, halt)) as pool:
        futures = [pool.submit(_run, task) for task in tasks]
        try:
            _follow(futures, news, tell)
        except BaseException:
            halt.set()
            for future in futures:
                future.cancel()
            raise
        return [_outcome(task, future) for task, future in zip(tasks, futures, strict=True)]


def _follow(
    futures: Sequence[Future[Outcome]], news: News, tell: Callable[[Standing], None]
) -> None:
    """Tell how far all have come, until they have ended."""
    for future in futures:
        future.add_done_callback(lambda _: news.put(_ENDED))
    left = len(futures)
    while left:
        standing = news.get()
        if standing is None:
            left -= 1
        else:
            tell(standing)


def _outcome(task: Task, future: Future[Outcome]) -> Outcome:
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise SoakEndedError(task.options.seed) from error


class _Worker:
    """What a process of the crew was given when it began."""

    news: News
    halt: Event


def _begin(news: News, halt: Event) -> None:
    _Worker.news, _Worker.halt = news, halt
    # Whoever is at the terminal interrupts all; the one that began this one says when it ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, name="watch of the parent", daemon=True).start()


def _end_with_parent() -> None:
    """Wait for the end of the process that began this one; without it nobody takes the outcome."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _run(task: Task) -> Outcome:
    run = SoakRun(task.options, task.checkpoint)
    for _ in run.jobs(task.hours):
        _Worker.news.put(run.standing())
        if _Worker.halt.is_set():
            break
    return run.outcome()
