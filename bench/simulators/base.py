"""What a simulator has to offer to be measured, and the floor and rays that all have."""

from __future__ import annotations

import importlib.util
import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from xavier_sim.floors import build_geometry, load_floor
from xavier_sim.messages import Corner, FloorPlan, Space, SpaceKind
from xavier_sim.profile import HARD, LIDAR, TICK

PLAN = load_floor()
BOX = 0.6
"""Metres along a side of a piece of furniture."""


def furnished(plan: FloorPlan) -> FloorPlan:
    """The floor with three boxes in each room, in the corners farthest from its door."""
    boxes: list[Space] = []
    for space in plan.spaces:
        if space.kind is not SpaceKind.ROOM or space.name not in plan.places:
            continue
        place, inset = plan.places[space.name], 0.1 + BOX / 2
        corners = [
            (x, y)
            for x in (space.low.x + inset, space.high.x - inset)
            for y in (space.low.y + inset, space.high.y - inset)
        ]
        corners.sort(key=lambda corner: -math.dist(corner, (place.x, place.y)))
        boxes += [_box(f"{space.name}-{number}", *at) for number, at in enumerate(corners[:3])]
    return plan.model_copy(update={"spaces": (*plan.spaces, *boxes)})


def _box(name: str, x: float, y: float) -> Space:
    low, high = Corner(x=x - BOX / 2, y=y - BOX / 2), Corner(x=x + BOX / 2, y=y + BOX / 2)
    return Space(name=name, kind=SpaceKind.ROOM, low=low, high=high)


class Setting:
    """A floor and the beams of the lidar on it; ``walls`` has shape (n, 4), doors stand open."""

    def __init__(self, plan: FloorPlan, beams: int) -> None:
        self.plan, self.beams = plan, beams
        self.walls = build_geometry(plan).walls


BARE, FURNISHED = Setting(PLAN, LIDAR.beams), Setting(furnished(PLAN), 300)

START = [(at.x, at.y) for _, at in sorted(PLAN.places.items())]
"""One room for each robot: where it begins."""

RADIUS = 0.305
SPEED, TURN = 0.15, 0.6
"""What each robot is told to do where there is no controller: small circles."""

LIDAR_RANGE, LIDAR_NOISE = LIDAR.farthest, LIDAR.noise

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
    setting: ClassVar[Setting] = BARE

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
