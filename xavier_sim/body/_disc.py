"""What stands on the floor, to physics, rays and passers-by alike: a disc."""

from __future__ import annotations

import math
from typing import NamedTuple


class Disc(NamedTuple):
    """Somebody or something upright, in metres; ``person`` tells a person from a thing."""

    x: float
    y: float
    radius: float
    person: bool = False

    def gap(self, x: float, y: float, radius: float) -> float:
        """Metres between this and another disc, negative when they overlap."""
        return math.hypot(x - self.x, y - self.y) - self.radius - radius
