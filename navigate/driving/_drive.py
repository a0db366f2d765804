"""A drive: what it has come to so far, and what ends it.

What the robot masters by itself is a trouble that was recovered from; only too much of it, or a
goal that cannot be reached, makes a failure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from navigate.body import Pose
from navigate.driving._courtesy import Courtesy
from navigate.driving._doorframe import Look
from navigate.driving._obeying import ObedienceWatch
from navigate.driving._view import (
    Astray,
    Bumped,
    Disobeyed,
    DoorMissed,
    DoorObstructed,
    DoorShut,
    DoorTrouble,
    Manoeuvre,
    OffCourse,
    Stuck,
    Trouble,
    WayBlocked,
)
from navigate.maps import Point
from navigate.messages import NavigationFailure
from navigate.routes import Step

LIMITS: dict[type[Trouble], tuple[int, NavigationFailure]] = {
    Bumped: (6, NavigationFailure.BUMP),
    DoorShut: (4, NavigationFailure.DOOR_BLOCKED),
    DoorObstructed: (4, NavigationFailure.DOOR_BLOCKED),
    DoorMissed: (3, NavigationFailure.DOOR_BLOCKED),
    OffCourse: (4, NavigationFailure.DOOR_BLOCKED),
    WayBlocked: (5, NavigationFailure.CORRIDOR_BLOCKED),
    Stuck: (2, NavigationFailure.NO_PROGRESS),
    Disobeyed: (3, NavigationFailure.NO_PROGRESS),
    Astray: (6, NavigationFailure.LOST),
}
"""How often each kind of trouble is recovered from in one drive, and what the next fails with."""


class GoalFailedError(Exception):
    """A drive ended without arriving.

    ``reason`` is its name on the bus; ``by_trouble`` says that the last trouble of the drive is
    what ended it.
    """

    def __init__(self, reason: NavigationFailure, text: str, *, by_trouble: bool = False) -> None:
        self.reason, self.text, self.by_trouble = reason, text, by_trouble
        super().__init__(text)


@dataclass(frozen=True)
class Findings:
    """What a drive found out about where the robot is.

    ``pose`` is where it stands on the map and ``look`` which way it looks, if that was measured;
    ``doubt`` are metres and radians by which the pose is less sure than it seemed. ``refuted`` says
    that it cannot be where it supposed to be while it was lost.
    """

    pose: Pose | None = None
    look: Look | None = None
    doubt: tuple[float, float] | None = None
    refuted: bool = False


@dataclass
class Drive:
    """What a drive has come to so far.

    ``goal`` and ``steps``, the route that is left, are in metres on the map; ``failure`` and
    ``done`` tell how it ended. ``findings`` are those of the last tick.
    """

    goal: Point
    began: float
    courtesy: Courtesy = field(default_factory=Courtesy)
    metres: float = 0.0
    troubles: list[Trouble] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    done: bool = False
    failure: GoalFailedError | None = None
    nearest: float = math.inf
    nearest_at: float = 0.0
    bumped_at: float = -math.inf
    planned_at: float = -math.inf
    in_door: bool = False
    findings: Findings = Findings()
    course: Manoeuvre[None] | None = None
    obedience: ObedienceWatch = field(default_factory=ObedienceWatch)

    @property
    def recoveries(self) -> int:
        """Troubles that the robot met and dealt with by itself."""
        return len(self.troubles) - (self.failure is not None and self.failure.by_trouble)

    @property
    def door(self) -> str | None:
        """The door that ended the drive, None if none did."""
        met = self.troubles[-1] if self.troubles else None
        ended = self.failure is not None and self.failure.by_trouble
        return met.door if ended and isinstance(met, DoorTrouble) else None

    def meet(self, trouble: Trouble) -> None:
        """Count a trouble.

        Raises:
            GoalFailedError: there were too many of its kind.
        """
        self.troubles.append(trouble)
        kind = next(kind for kind in LIMITS if isinstance(trouble, kind))
        most, reason = LIMITS[kind]
        if sum(isinstance(met, kind) for met in self.troubles) > most:
            text = f"{trouble}, for the {most + 1}. time on this drive"
            raise GoalFailedError(reason, text, by_trouble=True)

    def cancel(self) -> None:
        """End it, if it has not ended by itself."""
        if self.done:
            return
        if self.course is not None:
            self.course.close()
        self.done = True
        self.failure = GoalFailedError(NavigationFailure.CANCELLED, "the drive was cancelled")
