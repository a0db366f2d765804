"""A cart that somebody has left standing by a wall, until somebody else takes it away."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from xavier_sim.body import Disc
from xavier_sim.crowd._walkways import Point, Walkways

RADIUS = 0.35
"""Metres."""

OFF_WALL = 0.05
"""Metres between a cart and its wall."""

STAYS = 15 * 60.0
"""Seconds for which a cart stands, on average."""

STAYS_LEAST = 120.0

DOOR_CLEAR = 1.2
"""Carts are left at least this far from the middle of any door, metres."""

UNSEEN = 4.0
"""Carts come and go farther from a robot than this, metres."""

APART = 3.0
"""Metres between carts, so that there is a way between."""

TRIES = 200


@dataclass
class Cart:
    """Where a cart stands, in metres, and for how many seconds more."""

    x: float
    y: float
    stays: float

    def disc(self) -> Disc:
        """What others see of it."""
        return Disc(self.x, self.y, RADIUS)


class CartSpots:
    """Finds places for carts: along walls, clear of doors and of whoever is about.

    Args:
        walkways: where they can stand.
        doors: the middles of all doors, metres.
        random: the stream that chooses.
    """

    def __init__(
        self, walkways: Walkways, doors: Sequence[Point], random: np.random.Generator
    ) -> None:
        self._walkways, self._doors, self._random = walkways, doors, random

    def find(self, near: Sequence[Disc], carts: Sequence[Disc]) -> Point | None:
        """A free spot, None when there seems to be none.

        Args:
            near: whom it must not come near to.
            carts: the others.
        """
        for _ in range(TRIES):
            x, y = self._beside_side()
            if (
                self._walkways.has_room(x, y, RADIUS)
                and self._walkways.is_beside_wall(x, y, within=RADIUS + 2.0 * OFF_WALL)
                and all((x - a) ** 2 + (y - b) ** 2 > DOOR_CLEAR**2 for a, b in self._doors)
                and all(disc.gap(x, y, RADIUS) > UNSEEN for disc in near)
                and all(disc.gap(x, y, RADIUS) > APART for disc in carts)
            ):
                return x, y
        return None

    def stay(self) -> float:
        """For how many seconds a cart is left standing."""
        return max(STAYS_LEAST, float(self._random.exponential(STAYS)))

    def _beside_side(self) -> Point:
        """A point beside a side of some open space, which need not be a wall."""
        x, y = self._walkways.random_point(self._random, RADIUS)
        name = self._walkways.space_at(x, y)
        if name is None:
            return x, y
        low, high = self._walkways.spaces[name].low, self._walkways.spaces[name].high
        off = RADIUS + OFF_WALL
        sides = ((low.x + off, y), (high.x - off, y), (x, low.y + off), (x, high.y - off))
        return sides[int(self._random.integers(4))]
