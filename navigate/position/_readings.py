"""What was heard and seen lately and is not made use of yet.

A reading says the same some ticks later, if it is known where the robot was when it was taken:
dead reckoning is exact over so short a way. So readings are used in batches, a ring of sonars at
a time, which costs a quarter of what it costs one by one.
"""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigate.body import BEARINGS, RING_RADIUS, Pose
from navigate.maps import Floats

MOUNTS: Floats = np.column_stack(
    [RING_RADIUS * np.cos(BEARINGS), RING_RADIUS * np.sin(BEARINGS), BEARINGS]
)
"""Where each sonar is on the robot, and in which direction it looks: shape (24, 3)."""


class Heard(NamedTuple):
    """Readings of sonars, each with the pose (k, 3) of the robot in dead reckoning."""

    poses: Floats
    sonars: NDArray[np.intp]
    ranges: Floats


class Seen(NamedTuple):
    """What the striper saw: n poses of the robot in dead reckoning, and beams (n, b)."""

    poses: Floats
    beams: Floats


_Tick = tuple[Pose, list[int], Floats, Floats]


class Readings:
    """Those of some ticks, the oldest first; `count` of them are of sonars."""

    STATE: ClassVar[tuple[str, ...]] = ("_ticks", "_first", "count", "fresh")

    def __init__(self) -> None:
        self._ticks: list[_Tick] = []
        self._first = self.count = self.fresh = 0

    def add(self, pose: Pose, sonars: list[int], ranges: Floats, beams: Floats) -> None:
        """Add what was heard by some sonars, and seen, at a pose in dead reckoning."""
        self._ticks.append((pose, sonars, ranges[sonars], beams))
        self.count += len(sonars)
        self.fresh += len(sonars)

    @property
    def ticks(self) -> int:
        """How many ticks they are of."""
        return len(self._ticks)

    def clear(self) -> None:
        """Forget all of them."""
        self._ticks = []
        self._first = self.count = self.fresh = 0

    def latest(self) -> Heard:
        """The readings of sonars since the last call."""
        ticks = self._ticks[self._first :]
        self._first, self.fresh = len(self._ticks), 0
        return _heard(ticks)

    def everything(self) -> tuple[Heard, Seen]:
        """All that was heard and seen since it was last cleared."""
        with_beams = [tick for tick in self._ticks if len(tick[3])]
        beams = np.array([tick[3] for tick in with_beams])
        poses = np.array([tick[0] for tick in with_beams]).reshape(-1, 3)
        return _heard(self._ticks), Seen(poses, beams)


def _heard(ticks: list[_Tick]) -> Heard:
    if not ticks:
        return Heard(np.empty((0, 3)), np.empty(0, dtype=np.intp), np.empty(0))
    poses = np.array([tick[0] for tick in ticks])
    sonars = [number for tick in ticks for number in tick[1]]
    counts = [len(tick[1]) for tick in ticks]
    ranges = np.concatenate([tick[2] for tick in ticks])
    return Heard(poses.repeat(counts, axis=0), np.array(sonars, dtype=np.intp), ranges)


def seen_from(now: Pose, heard: Heard) -> Floats:
    """Where sonars were and looked, in the frame of a robot at ``now``: shape (k, 3)."""
    cos, sin = math.cos(now[2]), math.sin(now[2])
    dx, dy = heard.poses[:, 0] - now[0], heard.poses[:, 1] - now[1]
    turn = heard.poses[:, 2] - now[2]
    turn_cos, turn_sin = np.cos(turn), np.sin(turn)
    ahead, left, look = MOUNTS[heard.sonars].T
    seen = np.empty((len(turn), 3))
    seen[:, 0] = dx * cos + dy * sin + ahead * turn_cos - left * turn_sin
    seen[:, 1] = dy * cos - dx * sin + ahead * turn_sin + left * turn_cos
    seen[:, 2] = turn + look
    return seen
