"""One drive as somebody sees it who knows the truth."""

from __future__ import annotations

import math

from xavier_sim.messages import Sensors
from xavier_sim.profile import TICK
from xavier_sim.soak._contract import DriveReport, Pose
from xavier_sim.soak._errands import Goal
from xavier_sim.soak._jobs import Job, Way
from xavier_sim.soak._reaching import Reach
from xavier_sim.soak._tally import Tally
from xavier_sim.world import World

EVERY = 10
"""Ticks between two looks: one second."""


class Watch:
    """Follows a drive from its first tick to its last.

    Args:
        world: in which the robot drives; its doors are looked at when they move.
        goal: to which it is sent.
        number: of the job.
    """

    def __init__(self, world: World, reach: Reach, goal: Goal, *, number: int) -> None:
        self._world, self._reach, self._goal, self._number = world, reach, goal, number
        truth = world.truth()
        self._start, self._tick = truth.space, truth.tick
        self._metres, self._bumps = truth.metres, truth.bumps
        self._hit = truth.people_hit
        self._worst = 0.0
        self._open, self._shut = 0, 0
        self.doors_moved()

    @property
    def seconds(self) -> float:
        """Simulated seconds since the drive began."""
        return (self._world.tick - self._tick) * TICK

    def doors_moved(self) -> None:
        """Look anew whether there is a way to the goal."""
        here = self._world.truth().space
        if here is None or self._reach.reachable(here, self._goal.space, self._world.open_doors):
            self._open += 1
        else:
            self._shut += 1

    def look(self, believed: Pose, sensors: Sensors, tally: Tally) -> None:
        """Compare belief and truth once a second."""
        if self._world.tick % EVERY:
            return
        x, y, _ = self._world.pose
        error = math.dist((x, y), believed[:2])
        self._worst = max(self._worst, error)
        tally.sample(error=error, speed=sensors.speed)

    def judge(self, reason: str | None, report: DriveReport) -> Job:
        """The job as it ended; ``reason`` is None for a reported arrival."""
        truth = self._world.truth()
        off = math.dist((truth.x, truth.y), (self._goal.x, self._goal.y))
        return Job(
            number=self._number,
            began=round(self._tick * TICK, 1),
            start=self._start,
            goal=self._goal.name,
            way=self._way(),
            reason=reason,
            seconds=round(self.seconds, 1),
            metres=round(truth.metres - self._metres, 3),
            off=round(off, 3),
            worst_off=round(self._worst, 3),
            confidence=round(report.position.confidence, 4),
            recoveries=report.recoveries,
            bumps=truth.bumps - self._bumps,
            people_hit=truth.people_hit - self._hit,
        )

    def _way(self) -> Way:
        if self._open and self._shut:
            return Way.CHANGING
        return Way.OPEN if self._open else Way.SHUT
