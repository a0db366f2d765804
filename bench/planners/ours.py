"""ROGUE on PRODIGY: the agent's own domain, rules and search, without a bus."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from planners.office import HANDLING, SPEED, Instance, Job

from rogue.errands import Agenda, Claim, Errand, Switches, Travel, working
from rogue.prodigy import Execute, Search, Status, StepView


def errand(job: Job) -> Errand:
    """A job as the planner knows it."""
    return Errand(f"user-{job.name}", f"item-{job.name}", f"r-{job.pickup}", f"r-{job.deliver}")


@dataclass
class Office:
    """A search over an instance; ``clock`` is the simulated time."""

    instance: Instance
    clock: float = 0.0
    nodes: int = 0
    agenda: Agenda = field(init=False)
    switches: Switches = field(init=False)

    def __post_init__(self) -> None:
        travel = Travel(distance=self._metres, speed=SPEED, handling=HANDLING)
        self.agenda = Agenda(travel=travel, now=lambda: self.clock)
        for job in self.instance.jobs:
            one = errand(job)
            self.agenda.put(
                Claim(
                    user=one.user,
                    item=one.item,
                    person_rank=job.rank,
                    posted=job.posted,
                    deadline=job.deadline,
                )
            )

    def _metres(self, one: str, other: str) -> float:
        return self.instance.metres(int(one[2:]), int(other[2:]))

    def search(self, jobs: list[Job], at: int) -> Search:
        """A fresh search for jobs of which nothing is done."""
        self.switches = working(self.agenda)
        every = [errand(job) for job in self.instance.jobs]
        problem = self.switches.problem(
            [errand(job) for job in jobs],
            rooms=[f"r-{number}" for number in range(self.instance.rooms)],
            people=[one.user for one in every],
            items=[one.item for one in every],
            at=f"r-{at}",
        )
        return Search(problem, self.switches.options, self.switches.rules)

    def stop(self, step: StepView) -> tuple[Job, bool] | None:
        """The job and kind of stop of a hand-over; None for a drive."""
        if step.operator.startswith("goto"):
            return None
        name = str(step.args[2]).removeprefix("item-")
        job = next(job for job in self.instance.jobs if job.name == name)
        return job, step.operator == "deliver-item"


@dataclass(frozen=True)
class Planned:
    """How a batch went: seconds until the first step was known and until all were, and the way."""

    first: float
    whole: float
    metres: float
    nodes: int | None = None


def plan(instance: Instance) -> Planned | None:
    """Plan a batch and play it, so that every step of the plan is made; None if it is not solved.

    Making the search, in which the domain is read, is part of the time to the first step.
    """
    office = Office(instance)
    began = time.process_time()
    search = office.search(list(instance.jobs), instance.start)
    first, order = 0.0, list[tuple[Job, bool]]()
    for event in search.events():
        if isinstance(event, Execute):
            first = first or time.process_time() - began
            stop = office.stop(event.step)
            order += [stop] if stop else []
            search.executed()
    whole = time.process_time() - began
    if search.result is None or search.result.status is not Status.SOLVED:
        return None
    return Planned(first, whole, instance.length(order), len(search.nodes()))
