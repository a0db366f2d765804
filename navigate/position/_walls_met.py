"""What a sonar meets of a map: the nearest wall, shut door or tip of a wall in its cone.

Where that is met at right angles, or is the end of its line such as a door's jamb, its distance is
exact however wide the cone is, and so a *beacon*. After Leonard & Durrant-Whyte, Mobile Robot
Localization by Tracking Geometric Beacons (1991).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigate.body import CONE_HALF
from navigate.maps import Floats, Floor

REACH = 4.0
"""Metres within which walls are beacons, and beyond which a reading only says that none is."""

TILE = 1.0
"""Metres along a side of the squares for which the walls around are kept."""

MOST_TILES = 512
"""Squares for which they are kept at most; those around the robot come again soonest."""

PARALLEL = 1e-12
"""Keeps a line along the border of a cone from being divided by zero."""

_TANGENT = math.tan(CONE_HALF)

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Nearest:
    """The nearest points that k sonars meet.

    ``distance`` has shape (k,), inf for nothing; ``ahead`` and ``aside`` are the points in the
    frame of each sonar, metres; ``sharp`` says which of them are beacons.
    """

    distance: Floats
    ahead: Floats
    aside: Floats
    sharp: Flags


class _Lines:
    """Segments (m, 4), and what is reckoned of them once."""

    def __init__(self, lines: Floats, walls: int) -> None:
        self.walls = walls
        way = lines[:, 2:] - lines[:, :2]
        self.ends: Floats = np.ascontiguousarray(np.concatenate([lines[:, :2], way]).T)
        self.lengths: Floats = np.maximum((way**2).sum(axis=1), PARALLEL)


class WallsMet:
    """The walls and doors of a floor, looked up by place."""

    def __init__(self, floor: Floor) -> None:
        doors = np.array([door.segment() for door in floor.doors.values()]).reshape(-1, 4)
        self._lines = np.concatenate([floor.walls, doors])
        self._first_door = len(floor.walls)
        self._around = functools.lru_cache(maxsize=MOST_TILES)(self._lines_around)

    def nearest(self, sonars: Floats) -> tuple[Nearest, Nearest]:
        """What each of k sonars meets with all doors open, and with all of them shut.

        Args:
            sonars: x and y in metres, and the direction of look: shape (k, 3), about one place.
        """
        x, y = float(sonars[0, 0]), float(sonars[0, 1])
        lines = self._around(math.floor(x / TILE), math.floor(y / TILE))
        return nearest_points(lines.ends, lines.lengths, lines.walls, sonars)

    @property
    def kept(self) -> int:
        """For how many squares the walls around are kept now."""
        return self._around.cache_info().currsize

    def _lines_around(self, column: int, row: int) -> _Lines:
        """The lines in reach of any point of a square, by its number along x and y."""
        middle = (np.array((column, row)) + 0.5) * TILE
        reach = REACH + TILE
        corners = self._lines.reshape(-1, 2, 2)
        near = (corners.min(axis=1) < middle + reach).all(axis=1)
        near &= (corners.max(axis=1) > middle - reach).all(axis=1)
        walls = int(near[: self._first_door].sum())
        return _Lines(self._lines[near], walls)


def nearest_points(
    ends: Floats, lengths: Floats, walls: int, sonars: Floats
) -> tuple[Nearest, Nearest]:
    """What k sonars meet of the first ``walls`` of m lines, and of all of them.

    Args:
        ends: x and y of where lines begin, then their ways to where they end: shape (2, 2 m).
        lengths: the squares of their lengths, shape (m,).
        walls: how many lines are no doors.
        sonars: x, y, direction: shape (k, 3).
    """
    count, lines = len(sonars), len(lengths)
    if lines == 0:
        return _nothing(count), _nothing(count)
    cos, sin = np.cos(sonars[:, 2]), np.sin(sonars[:, 2])
    axes = np.empty((count, 2, 2))
    axes[:, 0, 0] = axes[:, 1, 1] = cos
    axes[:, 0, 1], axes[:, 1, 0] = sin, -sin
    turned = axes @ ends
    ahead, aside = turned[:, 0, :lines], turned[:, 1, :lines]
    ahead -= (cos * sonars[:, 0] + sin * sonars[:, 1])[:, None]
    aside -= (cos * sonars[:, 1] - sin * sonars[:, 0])[:, None]
    cast = _Cast(ahead, aside, turned[:, 0, lines:], turned[:, 1, lines:])
    first, last = _within_cone(cast)
    foot = cast.ahead * cast.way_ahead
    foot += cast.aside * cast.way_aside
    foot /= -lengths
    at = np.minimum(np.maximum(foot, first), last)
    squares = (cast.ahead + at * cast.way_ahead) ** 2
    squares += (cast.aside + at * cast.way_aside) ** 2
    np.copyto(squares, math.inf, where=first > last)
    opened = _pick(squares[:, :walls], cast, at, foot) if walls else _nothing(count)
    return opened, _pick(squares, cast, at, foot)


class _Cast(NamedTuple):
    """Lines as k sonars have them, (k, m) each: where they begin, and their ways to their ends."""

    ahead: Floats
    aside: Floats
    way_ahead: Floats
    way_aside: Floats


def _within_cone(cast: _Cast) -> tuple[Floats, Floats]:
    """The shares of lines at which they enter and leave cones; the first is greater outside."""
    along, change = _TANGENT * cast.ahead, _TANGENT * cast.way_ahead
    left = _crossing(along + cast.aside, change + cast.way_aside)
    right = _crossing(along - cast.aside, change - cast.way_aside)
    first = np.maximum(np.maximum(left[0], right[0]), 0.0)
    return first, np.minimum(np.minimum(left[1], right[1]), 1.0)


def _crossing(inside: Floats, change: Floats) -> tuple[Floats, Floats]:
    """The shares at which lines enter one border of a cone and leave it.

    Args:
        inside: how far inside of the border they begin.
        change: by how much more they end.
    """
    change += PARALLEL
    entering = change > 0.0
    crossing = inside
    crossing /= -change
    return np.where(entering, crossing, 0.0), np.where(entering, 1.0, crossing)


def _pick(squares: Floats, cast: _Cast, at: Floats, foot: Floats) -> Nearest:
    rows, picked = np.arange(len(squares)), squares.argmin(axis=1)
    share = at[rows, picked]
    ahead = cast.ahead[rows, picked] + share * cast.way_ahead[rows, picked]
    aside = cast.aside[rows, picked] + share * cast.way_aside[rows, picked]
    sharp = (share == foot[rows, picked]) | (share == 0.0) | (share == 1.0)
    return Nearest(np.sqrt(squares[rows, picked]), ahead, aside, sharp)


def _nothing(count: int) -> Nearest:
    zeros = np.zeros(count)
    return Nearest(np.full(count, math.inf), zeros, zeros, np.zeros(count, dtype=np.bool_))
