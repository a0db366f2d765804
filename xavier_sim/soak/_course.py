"""What a robot is put through, and what came of it: wherever it runs, in one process or many."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from xavier_sim.floors import build_geometry
from xavier_sim.messages import FloorPlan
from xavier_sim.profile import PROFILES
from xavier_sim.soak._doors import DoorKeeper
from xavier_sim.soak._errands import DoorTrials, Errands, RandomErrands
from xavier_sim.soak._examiner import Examiner
from xavier_sim.soak._jobs import Job
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._reaching import Reach
from xavier_sim.soak._tally import Tally
from xavier_sim.soak._watch import Seen, Watch

PATIENCE = 3
"""Jobs with an open way that may fail one after the other before somebody helps the robot."""


class Course:
    """Goals one after the other, doors that move meanwhile, and the jobs as they were judged.

    The same plan and options give the same goals and the same doors.

    Args:
        plan: the floor as it is.
        options: of the soak.
    """

    def __init__(self, plan: FloorPlan, options: SoakOptions) -> None:
        self.tally = Tally()
        self.doors = DoorKeeper(
            build_geometry(plan).door_names,
            shut_share=options.shut_share,
            moves_per_hour=options.door_moves_per_hour,
            seed=options.seed,
        )
        self._reach = Reach(plan)
        self._examiner = Examiner(plan, PROFILES[options.profile].base.radius)
        self._errands: Errands = (
            DoorTrials(plan, options.doors_in_and_out)
            if options.doors_in_and_out
            else RandomErrands(plan, options.seed)
        )
        self._unlucky = 0

    def next_job(self, seen: Seen, open_doors: Mapping[str, bool]) -> Watch | None:
        """The next errand of a robot that is where it was seen; None after the last.

        Args:
            seen: the robot before it is sent.
            open_doors: how every door stands, by its own name.
        """
        goal = self._errands.next(seen.space)
        if goal is None:
            return None
        number = len(self.tally.jobs)
        return Watch(self._reach, self._examiner, goal, seen, open_doors, number=number)

    def enter(self, job: Job) -> bool:
        """Count a job that was judged; true when somebody should help the robot now."""
        self.tally.jobs.append(job)
        self._unlucky = self._unlucky + 1 if job.went_wrong else 0
        if self._unlucky < PATIENCE:
            return False
        self._unlucky = 0
        self.tally.rescues += 1
        return True

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {
            "doors": self.doors.snapshot(),
            "errands": self._errands.snapshot(),
            "unlucky": self._unlucky,
            "tally": self.tally.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.doors.restore(state["doors"])
        self._errands.restore(state["errands"])
        self._unlucky = state["unlucky"]
        self.tally.restore(state["tally"])
