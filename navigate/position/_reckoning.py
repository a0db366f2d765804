"""Dead reckoning alone: what the wheels say, and nothing that the sonars say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from navigate.body import Motion, Pose, moved
from navigate.maps import Floats, Floor, Point
from navigate.position._localizer import NO_BEAMS, Belief, Estimate
from navigate.position._sonar_model import SonarModel

METRE_DOUBT = 0.03
"""Standard deviation of the position that a metre adds, metres."""

HEADING_DOUBT = 0.012
"""Standard deviation of the heading after a metre, radians; it grows with the root of the way."""


class DeadReckoning:
    """Adds up the motions from the start. The yardstick that every estimate has to beat.

    It is never lost, since nothing could tell it so, and never finds itself again.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_pose", "_deviation", "_turn_deviation")

    def __init__(self, floor: Floor) -> None:
        self._sonar = SonarModel(floor)
        start = floor.plan.start
        self.place((start.x, start.y, floor.plan.start_heading))

    @property
    def estimate(self) -> Estimate:
        """The pose reckoned, and doubts that grow with the way."""
        return Estimate(*self._pose, self._deviation, self._turn_deviation, 1.0)

    @property
    def lost(self) -> bool:
        """Never."""
        return False

    @property
    def supposes(self) -> bool:
        """Never."""
        return False

    def doubt(self) -> None:
        """Take no notice."""

    def belief(self) -> Belief:
        """All of it at the pose reckoned."""
        return Belief(np.array([self._pose]), np.ones(1))

    def place(self, pose: Pose, *, spread: float = 0.05, turn_spread: float = 0.03) -> None:
        """Go on from ``pose``."""
        self._pose, self._deviation, self._turn_deviation = pose, spread, turn_spread

    def orient(self, theta: float, *, spread: float) -> None:
        """Take no notice."""

    def widen(self, *, spread: float, turn_spread: float) -> None:
        """Doubt the position more."""
        self._deviation = math.hypot(self._deviation, spread)
        self._turn_deviation = math.hypot(self._turn_deviation, turn_spread)

    def move(self, motion: Motion) -> None:
        """Add a motion."""
        self._pose = moved(self._pose, motion)
        self._deviation += METRE_DOUBT * motion.metres
        growth = HEADING_DOUBT * math.sqrt(motion.metres)
        self._turn_deviation = math.hypot(self._turn_deviation, growth)

    def sense(self, ranges: Floats, fresh: int, *, still: bool, striper: Floats = NO_BEAMS) -> None:
        """Take no notice."""

    def notice(self, spots: Sequence[Point], *, within: float, sure: float) -> None:
        """Take no notice."""

    def mass_near(self, x: float, y: float, *, within: float) -> float:
        """1 within that distance, else 0."""
        return float(math.dist(self.estimate.pose[:2], (x, y)) <= within)

    def fit(self, pose: Pose, ranges: Floats) -> float:
        """The share of a ring of readings that a robot at ``pose`` would have, 0 to 1."""
        return self._sonar.fit(pose, ranges)

    def recover(self, ranges: Floats, *, radius: float) -> None:
        """Find nothing."""

    def way_to(self, goal: Point) -> float | None:
        """None: it is never lost."""
