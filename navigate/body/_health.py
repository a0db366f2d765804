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
from navigate.body._sonarring import NEAREST, mask_of, wrap
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

ROUND, LONGEST_ROUND = 4, 10
"""Ticks of a round at the least, and at the most, when some sonar is never new."""

ALL_NEW = (1 << SONAR_COUNT) - 1

FAR = 1e3
"""Metres that stand for no echo: finite, to be reckoned with."""

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
"""Weight of a new comparison in the mean."""

WAVER_MEMORY = 0.25
"""Weight of a new round in the share that waver."""


_LEFT, _RIGHT = (np.arange(SONAR_COUNT) + 1) % SONAR_COUNT, np.arange(SONAR_COUNT) - 1
"""The neighbour of each sonar on either side."""


class Condition(enum.IntEnum):
    """How a sense is."""

    SOUND = 0
    DEAD = 1
    STUCK = 2
    OFF = 3


class SonarHealth:
    """Judges each sonar of the ring, once in a round in which all were new, or should have been.

    ``unsound`` (24,) is true for those that are not to be believed, ``conditions`` says why.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "conditions", "unsound", "_silent", "_same", "_began", "_last", "_good", "_mark", "_waver",
        "_new", "_ticks",
    )  # fmt: skip

    def __init__(self) -> None:
        self.conditions = np.zeros(SONAR_COUNT, dtype=np.intp)
        self.unsound = np.zeros(SONAR_COUNT, dtype=np.bool_)
        self._silent = np.zeros(SONAR_COUNT, dtype=np.intp)
        self._same = np.zeros(SONAR_COUNT, dtype=np.intp)
        self._began: Floats = np.zeros(SONAR_COUNT)
        self._last: Floats = np.full(SONAR_COUNT, -1.0)
        self._good = np.zeros(SONAR_COUNT, dtype=np.intp)
        self._mark: Pose = (math.inf, 0.0, 0.0)
        self._waver = 0.0
        self._new, self._ticks = 0, 0

    @property
    def any_unsound(self) -> bool:
        """Whether there is one that is not to be believed."""
        return bool(np.count_nonzero(self.unsound))

    def judge(self, ranges: Floats, fresh: int, lit: Floats, odom: Pose) -> None:
        """Take in 24 readings, those in ``fresh`` new, beside what light sees in their cones."""
        self._new |= fresh
        self._ticks += 1
        if self._ticks < ROUND or (self._new != ALL_NEW and self._ticks < LONGEST_ROUND):
            return
        if self._new == 0:
            return
        new = mask_of(self._new)
        self._new = self._ticks = 0
        heard = np.isfinite(ranges)
        if is_elsewhere(odom, self._mark):
            self._mark = odom
            self._count_silence(np.where(heard, ranges, FAR), new, lit)
        same = new & heard & (np.abs(np.where(heard, ranges, FAR) - self._last) < SAME)
        self._count_same(new, new & heard, same, odom[2])
        self._find_faults(ranges, odom[2])
        if self.any_unsound:
            self._find_cured(new & heard, same)
        self._last = np.where(new & heard, ranges, self._last)

    def _count_silence(self, ranges: Floats, new: NDArray[np.bool_], lit: Floats) -> None:
        """Count the silent ones that should have heard something, here unlike before."""
        left, right = ranges[_LEFT], ranges[_RIGHT]
        met = (np.maximum(left, right) < WITNESSED) & (np.abs(left - right) < TOGETHER)
        if self.any_unsound:
            met &= ~(self.unsound[_LEFT] | self.unsound[_RIGHT])
        silent = new & (ranges == FAR)
        self._silent += silent & (met | (lit < WITNESSED))
        self._silent -= np.where(new & ~silent, np.minimum(self._silent, HEARD_COUNTS), 0)

    def _count_same(
        self,
        new: NDArray[np.bool_],
        heard: NDArray[np.bool_],
        same: NDArray[np.bool_],
        theta: float,
    ) -> None:
        self._same = np.where(same, self._same + 1, np.where(new, 0, self._same))
        self._began = np.where(new & ~same, theta, self._began)
        others = int((heard & ~self.unsound).sum())
        if others:
            wavering = 1.0 - int((same & ~self.unsound).sum()) / others
            self._waver += WAVER_MEMORY * (wavering - self._waver)

    def _find_faults(self, ranges: Floats, theta: float) -> None:
        dead, often = self._silent >= DEAD_AFTER, self._same >= STUCK_AFTER
        if often.any():
            turned = np.abs((self._began - theta + math.pi) % (2 * math.pi) - math.pi) > TURNED
            beside = np.minimum(ranges[_RIGHT], ranges[_LEFT])
            # What is too near to be told reads the same too, but not in one cone alone.
            told = ranges > NEAREST + SAME
            odd = told & (self._waver > WAVERING)
            odd |= turned & (told | (beside > NEAREST + TOGETHER))
            self._find(often & odd, Condition.STUCK)
        if dead.any():
            self._find(dead, Condition.DEAD)

    def _find(self, which: NDArray[np.bool_], condition: Condition) -> None:
        new = which & ~self.unsound
        self.conditions[new], self.unsound[new], self._good[new] = condition, True, 0

    def _find_cured(self, heard: NDArray[np.bool_], same: NDArray[np.bool_]) -> None:
        self._good = np.where(same, 0, self._good + heard)
        cured = self.unsound & (self._good >= SOUND_AFTER)
        self.conditions[cured], self.unsound[cured] = Condition.SOUND, False
        self._silent[cured] = self._same[cured] = 0


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
        if not bits or not is_elsewhere(odom, self._mark):
            return
        for sonar in bits:
            reading, seen = float(ranges[sonar]), float(sight.ring[sonar])
            if COMPARED[0] < reading < COMPARED[1] and abs(seen - reading) < COMPARABLE:
                self._mark = odom
                self._count = min(self._count + 1, OFF_AFTER)
                self._mean += max(MEMORY, 1.0 / self._count) * (seen - reading - self._mean)
        if self._count >= OFF_AFTER:
            self.off = abs(self._mean) > (RIGHT if self.off else OFF)


def is_elsewhere(odom: Pose, mark: Pose) -> bool:
    """Whether the robot has moved on from a mark so far that its senses say something new."""
    far = abs(odom[0] - mark[0]) + abs(odom[1] - mark[1]) > ELSEWHERE
    return far or abs(wrap(odom[2] - mark[2])) > ASKANCE
