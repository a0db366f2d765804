"""One drive as somebody sees it who knows the truth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from xavier_sim.profile import TICK
from xavier_sim.soak._contract import BlamesDoor, DriveReport, Pose
from xavier_sim.soak._errands import Goal
from xavier_sim.soak._evidence import Evidence
from xavier_sim.soak._examiner import Examiner, Upright
from xavier_sim.soak._jobs import Job
from xavier_sim.soak._reaching import Reach
from xavier_sim.soak._tally import Tally
from xavier_sim.soak._way import Way

LOOK_EVERY = 10
"""Ticks between two looks at where the robot is and believes to be: one second."""

DOOR_BLOCKED = "door_blocked"
"""The reason with which a navigator may name a door."""

TOLD_DIGITS = 4
"""Decimals of metres and radians that a navigator tells on the bus, so that both kinds of soak get
the same figures."""


class Seen(Protocol):
    """The truth about a robot: what the world says of it, and what it answers on the bus.

    Metres, and counts since the world began; ``tick`` may count from any beginning.
    """

    @property
    def x(self) -> float:
        """Metres east."""
        ...

    @property
    def y(self) -> float:
        """Metres north."""
        ...

    @property
    def theta(self) -> float:
        """Radians from east, counter-clockwise."""
        ...

    @property
    def space(self) -> str | None:
        """The space that it stands in."""
        ...

    @property
    def metres(self) -> float:
        """Metres driven."""
        ...

    @property
    def bumps(self) -> int:
        """Contacts."""
        ...

    @property
    def people_touched(self) -> int:
        """Contacts with people."""
        ...

    @property
    def people_hit(self) -> int:
        """Contacts in which it came towards somebody faster than 0.1 m/s."""
        ...

    @property
    def tick(self) -> int:
        """The control tick."""
        ...


class Watch:
    """Follows a drive from its first tick to its last.

    Args:
        reach: of the floor.
        examiner: of the floor.
        goal: to which the robot is sent.
        seen: the robot before it is sent.
        open_doors: how every door stands then, by its own name.
        number: of the job.
    """

    def __init__(
        self,
        reach: Reach,
        examiner: Examiner,
        goal: Goal,
        seen: Seen,
        open_doors: Mapping[str, bool],
        *,
        number: int,
    ) -> None:
        self.goal = goal
        self._evidence = Evidence(examiner, LOOK_EVERY * TICK)
        self._reach, self._number, self._before = reach, number, seen
        self._worst, self._sum, self._looks = 0.0, 0.0, 0
        self._last: float | None = None
        self._open, self._shut = 0, 0
        self.doors_moved(seen.space, open_doors, seen.tick)

    def seconds(self, tick: int) -> float:
        """Simulated seconds from the beginning of the drive to a tick."""
        return (tick - self._before.tick) * TICK

    def doors_moved(self, here: str | None, open_doors: Mapping[str, bool], tick: int) -> None:
        """Look anew whether there is a way from a space to the goal."""
        self._evidence.doors_moved(tick, open_doors)
        if here is None or self._reach.reachable(here, self.goal.space, open_doors):
            self._open += 1
        else:
            self._shut += 1

    def look(
        self,
        at: tuple[float, float],
        believed: tuple[float, float],
        speed: float,
        tally: Tally,
        around: Sequence[Upright],
    ) -> None:
        """Compare truth and belief, once in `LOOK_EVERY` ticks.

        Args:
            at: where the robot is, metres.
            believed: where its navigator says that it is.
            speed: that its wheels tell, m/s.
            tally: to count it in.
            around: who and what stands about, all of them or none.
        """
        told = round(believed[0], TOLD_DIGITS), round(believed[1], TOLD_DIGITS)
        error = math.dist(at, told)
        self._worst, self._last = max(self._worst, error), error
        self._sum, self._looks = self._sum + error, self._looks + 1
        self._evidence.look(at, told, around)
        tally.sample(error=error, speed=speed)

    def judge(
        self,
        reason: str | None,
        report: DriveReport,
        seen: Seen,
        believed: Pose,
        around: Sequence[Upright],
    ) -> Job:
        """The job as it ended with a robot that is seen now.

        Args:
            reason: of the failure that was reported, None for an arrival.
            report: what the navigator says of the drive.
            seen: the robot where it stands.
            believed: where its navigator says that it stands.
            around: who and what stands about.
        """
        job = self._job(reason, report, seen)
        if not job.went_wrong:
            return job
        facts = self._evidence.examine(
            (seen.x, seen.y, seen.theta),
            _as_told(believed),
            around,
            reason=reason,
            ends=(self._before.space, self.goal.space),
            blamed=_blamed(reason, report),
            tick=seen.tick,
        )
        return replace(job, post_mortem=facts)

    def _job(self, reason: str | None, report: DriveReport, seen: Seen) -> Job:
        before = self._before
        hit = seen.people_hit - before.people_hit
        return Job(
            number=self._number,
            began=round(before.tick * TICK, 1),
            start=before.space,
            goal=self.goal.name,
            way=self._way(),
            reason=reason,
            seconds=round(self.seconds(seen.tick), 1),
            metres=round(seen.metres - before.metres, 3),
            x=round(seen.x, 3),
            y=round(seen.y, 3),
            off=round(math.dist((seen.x, seen.y), (self.goal.x, self.goal.y)), 3),
            mean_off=round(self._sum / max(self._looks, 1), 3),
            worst_off=round(self._worst, 3),
            last_off=None if self._last is None else round(self._last, 3),
            confidence=round(report.position.confidence, 4),
            recoveries=report.recoveries,
            bumps=seen.bumps - before.bumps,
            people_hit=hit,
            walked_into=seen.people_touched - before.people_touched - hit,
        )

    def _way(self) -> Way:
        if self._open and self._shut:
            return Way.CHANGING
        return Way.OPEN if self._open else Way.SHUT


def _as_told(believed: Pose) -> Pose:
    x, y, theta = (round(value, TOLD_DIGITS) for value in believed)
    return x, y, theta


def _blamed(reason: str | None, report: DriveReport) -> str | None:
    """The room whose door a navigator says has ended the drive."""
    return report.door if reason == DOOR_BLOCKED and isinstance(report, BlamesDoor) else None
