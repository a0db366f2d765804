"""Carrying a soak on to its end: job after job, kept now and then, with its cost."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from xavier_sim.soak._checkpoint import CheckpointFile
from xavier_sim.soak._cost import Cost, Meter
from xavier_sim.soak._jobs import Job
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._soak import Soak
from xavier_sim.soak._summary import Outcome

SAVE_SECONDS = 10.0
"""Wall seconds between two checkpoints."""

FIRST_HOUR = 3600.0


class Standing(NamedTuple):
    """How far a soak has come: simulated ``seconds`` in ``wall`` seconds."""

    seed: int
    seconds: float
    metres: float
    jobs: int
    arrived: int
    wrong: int
    wall: float

    def __str__(self) -> str:
        """The same in a line."""
        return (
            f"{self.seconds / 3600:.2f} h, {self.metres / 1000:.2f} km, {self.jobs} jobs: "
            f"{self.arrived} completed, {self.jobs - self.arrived - self.wrong} rightly given up, "
            f"{self.wrong} wrong; {self.seconds / max(self.wall, 1e-9):.0f} x real time"
        )


class SoakRun:
    """A soak that begins anew, or goes on from its checkpoint if there is one.

    Args:
        options: of the soak.
        checkpoint: the file to keep it in.

    Raises:
        FloorError: the floor of the options is none.
        NavigatorError: the navigator of the options cannot be had.
        SnapshotError: the checkpoint cannot be used.
    """

    def __init__(self, options: SoakOptions, checkpoint: Path | None = None) -> None:
        self.soak = Soak(options)
        self._file = CheckpointFile(checkpoint) if checkpoint else None
        kept = self._file.load(self.soak) if self._file else None
        self.resumed = kept is not None
        self.cost = kept or Cost()

    def jobs(self, hours: float) -> Iterator[Job]:
        """Run jobs until so many simulated hours are over, or the errands are at their end.

        The last checkpoint is written when the iteration ends, for whatever reason.

        Raises:
            SnapshotError: a checkpoint cannot be written.
        """
        meter, saved = Meter(self.cost), time.monotonic()
        try:
            while self.soak.seconds < 3600.0 * hours:
                job = self.soak.run_job()
                if job is None:
                    break
                meter.read(early=self.soak.seconds <= FIRST_HOUR)
                if time.monotonic() - saved > SAVE_SECONDS:
                    self._save()
                    saved = time.monotonic()
                yield job
        finally:
            if not self.soak.driving:
                self._save()

    def outcome(self) -> Outcome:
        """What it came to so far."""
        return Outcome(self.soak.options, self.soak.course.tally, self.soak.seconds, self.cost)

    def standing(self) -> Standing:
        """How far it has come."""
        soak, jobs = self.soak, self.soak.course.tally.jobs
        return Standing(
            seed=soak.options.seed,
            seconds=soak.seconds,
            metres=sum(job.metres for job in jobs),
            jobs=len(jobs),
            arrived=sum(job.arrived for job in jobs),
            wrong=sum(job.went_wrong for job in jobs),
            wall=self.cost.wall,
        )

    def _save(self) -> None:
        if self._file is not None:
            self._file.save(self.soak, self.cost)
