"""Which senses are to be believed: each sonar and each laser against the others, over time.

A sonar that hears nothing where its neighbours, or light, meet something is *dead*; one that reads
the same to the last digit while others waver, or while the robot turns, is *stuck*; a laser that
measures otherwise than the sonars that look the same way is *off*. Whatever behaves again is
believed again.
"""

from __future__ import annotations

import enum
import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from navigate.body._lasers import Laser, Sight
from navigate.body._odometry import Pose
from navigate.body._sonarring import NEAREST, sonars_of, wrap
from navigate.maps import Floats
from xavier_sim.messages import SONAR_COUNT

WITNESSED = 2.5
"""Metres within which neighbours, or light, bear witness to what a sonar should hear."""

TOGETHER = 0.5
"""Metres between the readings of two neighbours that meet the same surface."""

DEAD_AFTER = 12
"""Times that a sonar must have heard nothing where it should have, before it counts as dead."""

HEARD_COUNTS = 4
"""Such times that one echo makes up for."""

ELSEWHERE, ASKANCE = 0.08, math.radians(6.0)
"""Metres driven, or radians turned, from which silence is news: at one place it stays the same."""

SAME = 1e-4
"""Metres within which two readings are the same."""

STUCK_AFTER = 12
"""The same readings running from which a sonar may be stuck."""

WAVERING = 0.7
"""Share of the sonars' readings that differ from the ones before, from which noise is there."""

TURNED = math.radians(60.0)
"""Radians turned under one reading from which it is stuck, whatever the noise."""

SOUND_AFTER = 4
"""Echoes, each another than the one before, after which a sonar is believed again."""

COMPARED = (0.4, 2.2)
"""Metres between which light and sonars are compared: the nearer is sharper."""

COMPARABLE = 0.35
"""Metres beyond which the two have not met the same thing."""

OFF, RIGHT = 0.06, 0.035
"""Metres of mean difference above which a laser is off, and below which it is right again."""

OFF_AFTER = 20
"""Comparisons that it takes."""

MEMORY = 0.06
"""Weight of a new comparison in the mean, and of a reading in the share that waver."""


class Condition(enum.IntEnum):
    """How a sense is."""

    SOUND = 0
    DEAD = 1
    STUCK = 2
    OFF = 3


class SonarHealth:
    """Judges each sonar of the ring.

    ``unsound`` (24,) is true for those that are not to be believed, ``conditions`` says why.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "conditions", "unsound", "_silent", "_same", "_began", "_last", "_good", "_marks", "_waver",
    )  # fmt: skip

    def __init__(self) -> None:
        self.conditions = np.zeros(SONAR_COUNT, dtype=np.intp)
        self.unsound = np.zeros(SONAR_COUNT, dtype=np.bool_)
        self._silent = np.zeros(SONAR_COUNT, dtype=np.intp)
        self._same = np.zeros(SONAR_COUNT, dtype=np.intp)
        self._began: Floats = np.zeros(SONAR_COUNT)
        self._last: Floats = np.full(SONAR_COUNT, np.inf)
        self._good = np.zeros(SONAR_COUNT, dtype=np.intp)
        self._marks: Floats = np.full((SONAR_COUNT, 3), np.inf)
        self._waver = 0.0

    def judge(self, ranges: Floats, fresh: int, lit: Floats, odom: Pose) -> None:
        """Take in the fresh ones of 24 readings, beside what light sees in their cones."""
        sonars = sonars_of(fresh)
        if len(sonars) == 0:
            return
        readings = ranges[sonars]
        heard = np.isfinite(readings)
        same = heard & (np.abs(np.where(heard, readings, 0.0) - self._last[sonars]) < SAME)
        self._count_silence(ranges, sonars, heard, lit[sonars], odom)
        self._count_same(sonars, heard, same, odom[2])
        self._judge(ranges, sonars, heard, same, odom[2])
        self._last[sonars] = np.where(heard, readings, self._last[sonars])

    def _count_silence(
        self,
        ranges: Floats,
        sonars: NDArray[np.intp],
        heard: NDArray[np.bool_],
        lit: Floats,
        odom: Pose,
    ) -> None:
        """Count the silent ones that should have heard something, at another place than before."""
        self._silent[sonars[heard]] = np.maximum(self._silent[sonars[heard]] - HEARD_COUNTS, 0)
        mute = sonars[~heard]
        if len(mute) == 0:
            return
        left, right = (mute + 1) % SONAR_COUNT, mute - 1
        witnesses = np.maximum(ranges[left], ranges[right]) < WITNESSED
        believed = ~(self.unsound[left] | self.unsound[right])
        alike = np.abs(_capped(ranges[left]) - _capped(ranges[right])) < TOGETHER
        met = (witnesses & believed & alike) | (lit[~heard] < WITNESSED)
        moved = self._marks[mute] - odom
        far = np.abs(moved[:, 0]) + np.abs(moved[:, 1]) > ELSEWHERE
        far |= np.abs(moved[:, 2]) > ASKANCE
        news = mute[met & far]
        self._silent[news] += 1
        self._marks[news] = odom

    def _count_same(
        self,
        sonars: NDArray[np.intp],
        heard: NDArray[np.bool_],
        same: NDArray[np.bool_],
        theta: float,
    ) -> None:
        self._same[sonars] = np.where(same, self._same[sonars] + 1, 0)
        self._began[sonars] = np.where(same, self._began[sonars], theta)
        others = heard & ~self.unsound[sonars]
        if others.any():
            wavering = 1.0 - float(same[others].mean())
            self._waver += MEMORY * (wavering - self._waver)

    def _judge(
        self,
        ranges: Floats,
        sonars: NDArray[np.intp],
        heard: NDArray[np.bool_],
        same: NDArray[np.bool_],
        theta: float,
    ) -> None:
        often = self._same[sonars] >= STUCK_AFTER
        if often.any() or self._silent[sonars].max() >= DEAD_AFTER:
            turned = np.abs((self._began[sonars] - theta + math.pi) % (2 * math.pi) - math.pi)
            beside = np.minimum(ranges[(sonars + 1) % SONAR_COUNT], ranges[sonars - 1])
            # What is too near to be told reads the same too, but not in one cone alone.
            told = ranges[sonars] > NEAREST + SAME
            odd = told & (self._waver > WAVERING)
            odd |= (turned > TURNED) & (told | (beside > NEAREST + TOGETHER))
            self._find(sonars[often & odd], Condition.STUCK)
            self._find(sonars[self._silent[sonars] >= DEAD_AFTER], Condition.DEAD)
        if self.unsound.any():
            self._good[sonars[same]] = 0
            self._good[sonars[heard & ~same]] += 1
            cured = sonars[self.unsound[sonars] & (self._good[sonars] >= SOUND_AFTER)]
            self.conditions[cured], self.unsound[cured] = Condition.SOUND, False
            self._silent[cured] = self._same[cured] = 0

    def _find(self, sonars: NDArray[np.intp], condition: Condition) -> None:
        new = sonars[~self.unsound[sonars]]
        self.conditions[new], self.unsound[new], self._good[new] = condition, True, 0


class LaserHealth:
    """Judges a laser by the sonars whose cones its beams fill."""

    STATE: ClassVar[tuple[str, ...]] = ("off", "_mean", "_count", "_mark")

    def __init__(self, laser: Laser) -> None:
        self._whole = np.flatnonzero(laser.whole)
        self.off = False
        self._mean, self._count = 0.0, 0
        self._mark: Pose = (math.inf, 0.0, 0.0)

    def judge(self, ranges: Floats, fresh: int, sight: Sight, odom: Pose) -> None:
        """Compare with the fresh ones of 24 readings, of which those to believe are finite."""
        bits = [sonar for sonar in self._whole.tolist() if fresh >> sonar & 1]
        if not bits or not self._is_elsewhere(odom):
            return
        for sonar in bits:
            reading, seen = float(ranges[sonar]), float(sight.ring[sonar])
            if COMPARED[0] < reading < COMPARED[1] and abs(seen - reading) < COMPARABLE:
                self._mark = odom
                self._count = min(self._count + 1, OFF_AFTER)
                self._mean += max(MEMORY, 1.0 / self._count) * (seen - reading - self._mean)
        if self._count >= OFF_AFTER:
            self.off = abs(self._mean) > (RIGHT if self.off else OFF)

    def _is_elsewhere(self, odom: Pose) -> bool:
        x, y, theta = self._mark
        far = abs(odom[0] - x) + abs(odom[1] - y) > ELSEWHERE
        return far or abs(wrap(odom[2] - theta)) > ASKANCE


def _capped(ranges: Floats) -> Floats:
    return np.minimum(ranges, 1e3)
