"""How sure the navigator may be that the robot stands at a room.

On a corridor of like doors an estimator is sure of the wrong one as easily as of the right
one: wheels that slip by one door's distance leave no trace in what the sonars hear. So some doubt
is left for every neighbour whose place would look the same, until somebody says where it is.
"""

from __future__ import annotations

import math
from typing import ClassVar

from navigate.body import Pose
from navigate.maps import Floats, Floor, Point
from navigate.position._localizer import Localizer

AT_PLACE = 0.6
"""Metres from a room's place within which belief counts as being there."""

ALIKE_REACH = 8.0
"""Metres within which the place of another room may be taken for this one: two doors."""

ALIKE_FIT = 0.1
"""A place whose readings fit worse than here by no more than this share looks the same."""

ALIKE_DOUBT = 0.1
"""What belief leaves for the chance to be at a place that looks the same."""

SOUND_AGREEMENT = 0.8
"""Share of readings that agree with a sound estimate; fewer make it less sure."""

TOLD_REACH = 1.0
"""Metres for which the word of somebody who said where the robot is stays good."""


class Confidence:
    """Judges an estimate; remembers what the navigator was told."""

    STATE: ClassVar[tuple[str, ...]] = ("_told",)

    def __init__(self, floor: Floor, localizer: Localizer) -> None:
        self._floor, self._localizer = floor, localizer
        self._told: tuple[str, Point] | None = None

    def told(self, room: str, odom: Pose | None) -> None:
        """Somebody said that the robot is at a room, while odometry stood at ``odom``."""
        self._told = (room, odom[:2]) if odom is not None else None

    def at(self, room: str | None, ranges: Floats, odom: Pose | None) -> float:
        """The probability that the robot is at a room's place, 0 to 1.

        Args:
            room: that the estimate names, if any.
            ranges: the latest reading of each sonar, metres from the ring.
            odom: the pose by odometry.
        """
        if room is None:
            return 0.0
        localizer, (x, y) = self._localizer, self._floor.place(room)
        mass = localizer.mass_near(x, y, within=AT_PLACE)
        sound = min(1.0, localizer.estimate.agreement / SOUND_AGREEMENT)
        doubt = ALIKE_DOUBT if self._looks_alike(room, ranges) else 0.0
        if self._was_told(room, odom):
            doubt = 0.0
        return mass * sound * (1.0 - doubt)

    def _was_told(self, room: str, odom: Pose | None) -> bool:
        if self._told is None or odom is None:
            return False
        told, at = self._told
        return told == room and math.dist(at, odom[:2]) <= TOLD_REACH

    def _looks_alike(self, room: str, ranges: Floats) -> bool:
        """Whether a neighbour's place would sound the same."""
        x, y, theta = self._localizer.estimate.pose
        here = self._floor.place(room)
        least = self._localizer.fit((x, y, theta), ranges) - ALIKE_FIT
        for other, (other_x, other_y) in self._floor.places.items():
            if other == room or math.dist(here, (other_x, other_y)) > ALIKE_REACH:
                continue
            moved = (x + other_x - here[0], y + other_y - here[1], theta)
            if self._localizer.fit(moved, ranges) >= least:
                return True
        return False
