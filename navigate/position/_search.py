"""Looking for a lost robot: which of many poses would hear what is heard now.

In two steps, since the likelihood of a ring of readings has peaks a hand's breadth wide: poses on
a coarse grid in every likely cell, then on a fine one around the best of the best cells. What is
found counts only if it stands out among all cells that were looked at.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigate.body import Pose
from navigate.maps import Floats
from navigate.position._sonar_model import SonarModel

FINALISTS = 48
"""Cells that are looked at again on the fine grid."""

TEMPER = 0.35
"""Exponent of the likelihood of a whole ring: its readings err together."""

SAME = 1.0
"""Metres within which two poses that fit are the same."""

LOOKS_ALIKE = 0.7
"""Cosine of the angle between their headings from which they are."""


class Found(NamedTuple):
    """The best pose, and its share among all that might be meant instead, 0 to 1."""

    pose: Pose
    share: float


def _offsets(reach: float, steps: int, turn: float, turns: int) -> Floats:
    along, look = np.linspace(-reach, reach, steps), np.linspace(-turn, turn, turns)
    grid = np.meshgrid(along, along, look, indexing="ij")
    return np.stack([part.ravel() for part in grid], axis=1)


_COARSE = _offsets(0.4, 3, 0.1, 2)
_FINE = _offsets(0.2, 5, 0.08, 3)


def search(sonar: SonarModel, middles: Floats, mass: Floats, ranges: Floats) -> Found | None:
    """The pose in or around n cells at which a ring of readings would be heard.

    Args:
        sonar: how probable readings are.
        middles: poses (n, 3) in the middles of the cells.
        mass: how probable each cell is without the readings, shape (n,).
        ranges: the 24 readings; None is found where none of them is an echo.
    """
    heard = np.flatnonzero(np.isfinite(ranges))
    if len(heard) == 0 or len(middles) == 0:
        return None
    readings = ranges[heard]
    poses, fits = _best(sonar, middles, _COARSE, readings, heard)
    weights = TEMPER * fits + np.log(mass)
    best = np.argsort(-weights, kind="stable")[:FINALISTS]
    poses, fits = _best(sonar, poses[best], _FINE, readings, heard)
    weights = TEMPER * fits + np.log(mass[best])
    shares = np.exp(weights - weights.max())
    winner = poses[int(shares.argmax())]
    near = np.hypot(poses[:, 0] - winner[0], poses[:, 1] - winner[1]) < SAME
    near &= np.cos(poses[:, 2] - winner[2]) > LOOKS_ALIKE
    x, y, theta = winner.tolist()
    pose = (x, y, math.remainder(theta, 2.0 * math.pi))
    return Found(pose, float(shares[near].sum() / shares.sum()))


def _best(
    sonar: SonarModel, middles: Floats, offsets: Floats, readings: Floats, sonars: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """The best pose around each of n middles, shape (n, 3), and its log likelihood, shape (n,)."""
    poses = middles[:, None] + offsets
    x, y, theta = poses.reshape(-1, 3).T
    fits = sonar.log_likelihood(x, y, theta, readings, sonars).reshape(len(middles), -1)
    best = fits.argmax(axis=1)
    rows = np.arange(len(middles))
    return poses[rows, best], fits[rows, best]
