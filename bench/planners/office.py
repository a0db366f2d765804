"""Random errands in a ring of rooms, as all planners get them, and the shortest way."""

from __future__ import annotations

import functools
import random
from dataclasses import dataclass

SPEED = 0.4
"""Metres a second of the robot on its way."""

HANDLING = 30.0
"""Seconds at each stop."""

APART = 3.0
"""Metres from door to door along the ring."""


@dataclass(frozen=True)
class Job:
    """An errand: rooms by number; ``rank``, ``posted`` and ``deadline`` count in streams only."""

    name: str
    pickup: int
    deliver: int
    rank: int = 0
    posted: float = 0.0
    deadline: float = float("inf")

    @property
    def weight(self) -> float:
        """What a second of waiting counts."""
        return 1.0 + self.rank


@dataclass(frozen=True)
class Instance:
    """Errands that are known at once; the robot begins in room ``start`` and may end anywhere."""

    rooms: int
    start: int
    jobs: tuple[Job, ...]

    def metres(self, one: int, other: int) -> float:
        """Metres between two rooms, the shorter way round."""
        apart = (one - other) % self.rooms
        return APART * min(apart, self.rooms - apart)

    def length(self, order: list[tuple[Job, bool]]) -> float:
        """Metres of a way through stops: a job, and whether it is its delivery."""
        here, metres = self.start, 0.0
        for job, is_delivery in order:
            room = job.deliver if is_delivery else job.pickup
            metres, here = metres + self.metres(here, room), room
        return metres


def batch(rooms: int, count: int, seed: int) -> Instance:
    """``count`` deliveries between random rooms."""
    chance = random.Random(f"{rooms} {count} {seed}")
    jobs = tuple(Job(f"job{i}", *chance.sample(range(rooms), 2)) for i in range(count))
    return Instance(rooms, chance.randrange(rooms), jobs)


def stream(rooms: int, count: int, seed: int, every: float) -> Instance:
    """``count`` deliveries that arrive at random, on the average ``every`` so many seconds."""
    chance = random.Random(f"stream {rooms} {count} {seed}")
    jobs, time = [], 0.0
    for number in range(count):
        time += chance.expovariate(1.0 / every)
        pickup, deliver = chance.sample(range(rooms), 2)
        rank = chance.choice((1, 1, 1, 3, 3, 5)) + chance.randrange(4)
        deadline = time + chance.choice((900.0, 1800.0, 3600.0, 3600.0))
        jobs.append(Job(f"job{number}", pickup, deliver, rank, time, deadline))
    return Instance(rooms, chance.randrange(rooms), tuple(jobs))


def shortest(instance: Instance) -> float:
    """Metres of the shortest way, by dynamic programming over what is done of each errand.

    Written anew, so that it checks the planner's own tour and does not share its mistakes.
    """
    jobs = instance.jobs

    @functools.cache
    def rest(here: int, done: tuple[int, ...]) -> float:
        best = 0.0 if all(one == 2 for one in done) else float("inf")
        for number, stage in enumerate(done):
            if stage < 2:
                room = jobs[number].deliver if stage else jobs[number].pickup
                after = (*done[:number], stage + 1, *done[number + 1 :])
                best = min(best, instance.metres(here, room) + rest(room, after))
        return best

    return rest(instance.start, (0,) * len(jobs))
