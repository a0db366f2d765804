"""How often the robot got stuck on its way through doors, recovered, and gave up."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from pydantic import BaseModel, ConfigDict

from xavier_sim.soak._errands import room_of
from xavier_sim.soak._jobs import Job
from xavier_sim.soak._way import Way


class DoorRates(BaseModel):
    """What came of drives into rooms and out of them, of those whose way was open at all times.

    ``stuck`` are those on which the robot met trouble, in the door or elsewhere on the drive: it
    ``recovered`` and arrived, or the drive was ``given_up``. ``stuck_share`` and
    ``given_up_share`` are of all drives, ``recovered_share`` is of those stuck, None of none.
    """

    model_config = ConfigDict(frozen=True)

    drives: int
    completed: int
    stuck: int
    stuck_share: float | None
    recovered: int
    recovered_share: float | None
    given_up: int
    given_up_share: float | None


def door_rates(jobs: Sequence[Job]) -> DoorRates:
    """Count over some jobs."""
    tried = [job for job in jobs if job.way is Way.OPEN]
    given_up = sum(job.reason is not None for job in tried)
    stuck = [job for job in tried if job.recoveries or job.reason is not None]
    recovered = sum(job.arrived for job in stuck)
    return DoorRates(
        drives=len(tried),
        completed=sum(job.arrived for job in tried),
        stuck=len(stuck),
        stuck_share=_share(len(stuck), len(tried)),
        recovered=recovered,
        recovered_share=_share(recovered, len(stuck)),
        given_up=given_up,
        given_up_share=_share(given_up, len(tried)),
    )


def by_door(jobs: Sequence[Job]) -> dict[str, list[Job]]:
    """The jobs of each room's door, in and out, by the names of the rooms."""
    found = defaultdict[str, list[Job]](list)
    for job in jobs:
        found[room_of(job.goal)].append(job)
    return dict(sorted(found.items()))


def _share(part: int, whole: int) -> float | None:
    return round(part / whole, 5) if whole else None
