"""Errands that arrive while others run, and who serves them in which order.

All robots are alike: they drive at one speed, take a while at each stop, finish the drive or the
hand-over that they are at when something arrives, and have a tray without bounds.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from planners.office import HANDLING, SPEED, Instance, Job
from planners.others import Open, route
from planners.ours import Office, errand

from rogue.prodigy import Execute, Search

Choose = Callable[[int, list[Open], float], tuple[Job, bool]]
"""The next stop, told the room, what is open in order of arrival, and the time."""


@dataclass
class Record:
    """What came of a stream."""

    delivered: dict[str, float] = field(default_factory=dict)
    metres: float = 0.0
    reactions: list[float] = field(default_factory=list)
    redone: int = 0
    nodes: int = 0

    def weighted_waiting(self, jobs: Sequence[Job]) -> float:
        """Seconds from posting to delivery, weighted by priority, on the average."""
        total = sum(job.weight * (self.delivered[job.name] - job.posted) for job in jobs)
        return total / sum(job.weight for job in jobs)

    def missed(self, jobs: Sequence[Job]) -> int:
        """Errands that were delivered after their deadlines."""
        return sum(self.delivered[job.name] > job.deadline for job in jobs)


def dispatch(instance: Instance, make: Callable[[Instance], Choose]) -> Record:
    """Serve a stream stop by stop, as ``choose`` says."""
    record, choose = Record(), make(instance)
    waiting, carried = list(instance.jobs), list[Job]()
    now, here, known_before = 0.0, instance.start, set[Job]()
    while waiting or carried:
        known = [job for job in waiting if job.posted <= now]
        if not known and not carried:
            now = min(job.posted for job in waiting)
            continue
        listed = [Open(job) for job in known] + [Open(job, is_carried=True) for job in carried]
        listed.sort(key=lambda one: one.job.posted)
        began, is_new = time.process_time(), not known_before.issuperset(known)
        job, is_delivery = choose(here, listed, now)
        known_before.update(known)
        if is_new:
            record.reactions.append(time.process_time() - began)
        room = job.deliver if is_delivery else job.pickup
        metres = instance.metres(here, room)
        now, here = now + metres / SPEED + HANDLING, room
        record.metres += metres
        (carried if is_delivery else waiting).remove(job)
        if is_delivery:
            record.delivered[job.name] = now
        else:
            carried.append(job)
    return record


def first_come(_instance: Instance) -> Choose:
    """One errand after the other, as they came."""
    return lambda _here, jobs, _now: (jobs[0].job, jobs[0].is_carried)


def nearest_first(instance: Instance) -> Choose:
    """Whatever stop is nearest."""

    def choose(here: int, jobs: list[Open], _now: float) -> tuple[Job, bool]:
        def metres(one: Open) -> float:
            return instance.metres(here, one.job.deliver if one.is_carried else one.job.pickup)

        best = min(jobs, key=metres)
        return best.job, best.is_carried

    return choose


def resolved(seconds: float) -> Callable[[Instance], Choose]:
    """OR-Tools for the least weighted waiting, solved anew whenever something has arrived."""

    def make(instance: Instance) -> Choose:
        plan: list[tuple[Job, bool]] = []
        seen: set[str] = set()

        def choose(here: int, jobs: list[Open], _now: float) -> tuple[Job, bool]:
            names = {one.job.name for one in jobs}
            if not names <= seen:
                seen.update(names)
                plan[:] = route(instance, jobs, here, seconds=seconds, weighted=True)
            return plan.pop(0)

        return choose

    return make


def ours(instance: Instance) -> Record:
    """ROGUE: one search as long as there is something to do, told of what arrives."""
    record, office = Record(), Office(instance)
    waiting, here = list(instance.jobs), instance.start
    while waiting:
        office.clock = max(office.clock, waiting[0].posted)
        here = _episode(record, office, waiting, here)
    return record


def _arrived(office: Office, waiting: list[Job]) -> list[Job]:
    """Take from the waiting jobs those that have come."""
    arrived = [job for job in waiting if job.posted <= office.clock]
    del waiting[: len(arrived)]
    return arrived


def _episode(record: Record, office: Office, waiting: list[Job], here: int) -> int:
    began: float | None = time.process_time()
    search = office.search(_arrived(office, waiting), here)
    acquired = set[str]()
    for event in search.events():
        if not isinstance(event, Execute):
            continue
        if began is not None:
            record.reactions.append(time.process_time() - began)
            began = None
        here = _perform(record, office, event, here, acquired)
        new = _arrived(office, waiting)
        if new:
            began = time.process_time()
            _tell(office, search, new)
        search.executed()
    record.nodes += len(search.nodes())
    return here


def _tell(office: Office, search: Search, jobs: list[Job]) -> None:
    for job in jobs:
        one = errand(job)
        search.add_goal(office.switches.facts(one), office.switches.goal(one))


def _perform(record: Record, office: Office, event: Execute, here: int, acquired: set[str]) -> int:
    stop = office.stop(event.step)
    if stop is None:
        room = int(str(event.step.args[1])[2:])
        metres = office.instance.metres(here, room)
        record.metres += metres
        office.clock += metres / SPEED
        return room
    office.clock += HANDLING
    job, is_delivery = stop
    if is_delivery:
        record.delivered[job.name] = office.clock
    else:
        record.redone += job.name in acquired
        acquired.add(job.name)
    return here
