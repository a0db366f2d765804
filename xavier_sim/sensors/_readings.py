"""Range readings in a snapshot: plain numbers, and None where nothing was met."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Ranges = NDArray[np.float32]

Pose = tuple[float, float, float]
"""Metres and radians in the frame of the floor."""


def plain(ranges: Iterable[float]) -> list[float | None]:
    """Ranges in metres as JSON can hold them."""
    return [float(one) if math.isfinite(one) else None for one in ranges]


def ranges_of(kept: Iterable[float | None]) -> Ranges:
    """What `plain` was made of."""
    return np.array([math.inf if one is None else one for one in kept], dtype=np.float32)
