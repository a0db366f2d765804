"""What a simulator has to offer to be measured, and the floor and rays that all have."""

from __future__ import annotations

import importlib.util
import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from xavier_sim.floors import build_geometry, load_floor
from xavier_sim.profile import HARD, LIDAR, TICK

PLAN = load_floor()
WALLS = build_geometry(PLAN).walls
"""The walls of the floor, shape (n, 4); its doors stand open."""

START = [(at.x, at.y) for _, at in sorted(PLAN.places.items())]
"""One room for each robot: where it begins."""

RADIUS = 0.305
SPEED, TURN = 0.15, 0.6
"""What each robot is told to do where there is no controller: small circles."""

LIDAR_BEAMS, LIDAR_RANGE, LIDAR_NOISE = LIDAR.beams, LIDAR.farthest, LIDAR.noise

assert HARD.sonar is not None
assert HARD.striper is not None
SONAR_RAYS = math.ceil(24 * HARD.sonar.rays / HARD.sonar.phases)
"""Rays of the sonar ring at a tick: each cone has several, and fires every fifth tick."""
SONAR_RANGE = HARD.sonar.farthest
STRIPER_BEAMS, STRIPER_RANGE = HARD.striper.beams, HARD.striper.farthest
STRIPER_VIEW = HARD.striper.view


class Simulator(ABC):
    """So many robots on the floor, and ticks of 0.1 s.

    ``group`` is what it is compared in; ``title`` its row; ``package`` what it needs.
    """

    title: ClassVar[str]
    group: ClassVar[str]
    package: ClassVar[str | None] = None

    def __init__(self, robots: int) -> None:
        self.robots = robots

    @abstractmethod
    def tick(self) -> None:
        """Sense, decide, move: 0.1 s of all robots."""

    @abstractmethod
    def ranges(self) -> np.ndarray:
        """What the first robot's scanner measured last, metres: to see that it works."""

    @classmethod
    def missing(cls) -> str | None:
        """Why it cannot be measured here, None if it can."""
        if cls.package is None or importlib.util.find_spec(cls.package):
            return None
        return f"{cls.package} is not installed"


PERIOD = TICK
