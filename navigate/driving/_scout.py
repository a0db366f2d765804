"""What a lost robot may do with the map: drive as if it were where it supposes to be."""

from __future__ import annotations

import math
from collections.abc import Callable

from navigate.driving._drive import Drive, Findings
from navigate.driving._view import Manoeuvre, Trouble, View
from navigate.maps import Floor, Point

FAR_OFF, FARTHER = 10.0, 5.0
"""Metres to a place that tells more than the one where the robot is, and to each further one."""

Attempt = Callable[[Drive, View], Manoeuvre[View]]


class Scout:
    """Drives a robot that searches for itself on one drive.

    Args:
        drive: what it searches for itself on.
        attempt: plans from where a view says that the robot is, and drives the way.
        floor: the map.
    """

    def __init__(self, drive: Drive, attempt: Attempt, floor: Floor) -> None:
        self._drive, self._attempt, self._floor = drive, attempt, floor
        self._beyond = FAR_OFF

    def to_goal(self, view: View) -> Manoeuvre[View]:
        """Drive to the goal."""
        return self._attempt(self._to(self._drive.goal, view), view)

    def elsewhere(self, view: View) -> Manoeuvre[View]:
        """Drive to a room some way off, each time to one that is farther."""
        rooms = sorted(self._floor.places.values(), key=lambda room: math.dist(room, view.at))
        far = [room for room in rooms if math.dist(room, view.at) > self._beyond]
        self._beyond += FARTHER
        return self._attempt(self._to((far or rooms)[0], view), view)

    def meet(self, trouble: Trouble) -> None:
        """Count a trouble.

        Raises:
            GoalFailedError: there were too many of its kind.
        """
        self._drive.meet(trouble)

    def refute(self) -> None:
        """Say that the robot cannot be where it supposes: the way that should be there is not."""
        self._drive.findings = Findings(refuted=True)

    def _to(self, goal: Point, view: View) -> Drive:
        return Drive(goal, view.time, self._drive.courtesy)
