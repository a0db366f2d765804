"""Virtual sensors: what the grid around the robot says of its front and its sides.

After Koenig & Simmons (1998): the front reports a wall or none, each side a wall or a small,
medium or large opening; what is not known is not reported.
"""

from __future__ import annotations

import enum
import math

import numpy as np
from numpy.typing import NDArray

from navigate.body._localgrid import LocalGrid
from navigate.body._odometry import Pose
from navigate.maps import Floats

BEHIND, AHEAD = 1.4, 0.2
"""Metres before and behind the robot between which the floor beside it is looked at."""

BESIDE = 2.2
"""Metres from the robot's middle within which something beside it is a wall."""

FRONT_REACH = 2.0
"""Metres from the robot's middle within which something ahead is a wall."""

STRIP = 0.1
"""Metres of floor along the robot's way that are open or not."""

KNOWN = 0.5
"""Share of the strips that must be known for a report."""

SHARES: Floats = np.array([0.12, 0.55, 0.9])
"""Shares of open strips from which an opening is small, medium and large."""

SEEN = 0.5
"""Evidence, in log odds, from which a cell counts as free or occupied."""


class Side(enum.IntEnum):
    """What is beside the robot."""

    WALL = 0
    SMALL = 1
    MEDIUM = 2
    LARGE = 3


class Front(enum.IntEnum):
    """What is before it."""

    WALL = 0
    CLEAR = 1


def side_of_share(share: Floats) -> NDArray[np.intp]:
    """The `Side` for each share of open strips, any shape."""
    return np.asarray(np.searchsorted(SHARES, share, side="right"))


def look_front(grid: LocalGrid, pose: Pose) -> Front | None:
    """What is before a robot that looks along ``pose``; None when that is not known."""
    ahead, aside = np.meshgrid(np.arange(0.35, FRONT_REACH, 0.1), np.arange(-0.2, 0.21, 0.1))
    evidence = _look(grid, pose, ahead, aside)
    if (evidence > SEEN).any():
        return Front.WALL
    middle = evidence[1:-1]
    return Front.CLEAR if (middle < -SEEN).mean() > KNOWN else None


def look_aside(grid: LocalGrid, pose: Pose, *, left: bool) -> Side | None:
    """What is beside a robot that looks along ``pose``; None when that is not known."""
    along = np.arange(-BEHIND, AHEAD, STRIP) + STRIP / 2
    away = np.arange(0.35, BESIDE + 0.1, 0.1)
    evidence = _look(grid, pose, along[:, None], (away if left else -away)[None, :])
    solid = (evidence > SEEN).any(axis=1)
    open_ = ~solid & (evidence[:, -3:] < -SEEN).any(axis=1)
    known = int(solid.sum() + open_.sum())
    if known < KNOWN * len(along):
        return None
    return Side(int(side_of_share(np.array(open_.sum() / known))))


def _look(grid: LocalGrid, pose: Pose, ahead: Floats, left: Floats) -> Floats:
    x, y, theta = pose
    cos, sin = math.cos(theta), math.sin(theta)
    return grid.evidence(x + ahead * cos - left * sin, y + ahead * sin + left * cos)
