"""Tracking a pose by walls and corners: an extended Kalman filter over odometry and sonar.

A sonar reads the distance of the nearest thing in its cone. Where that is a wall met at right
angles, or the tip of a wall such as a door's jamb, the distance is exact however wide the cone
is, and tells the robot's place along one direction. After Leonard & Durrant-Whyte, Mobile Robot
Localization by Tracking Geometric Beacons (1991).
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from navigate.body import CONE_HALF, RING_RADIUS, Motion, Pose, wrap
from navigate.maps import Floats, Floor

DRIFT = 0.006
"""Doubt about how the heading drifts, radians per metre."""

METRE_NOISE, SCALE_NOISE = 0.03, 0.02
"""Doubt about a distance: metres per square root of a metre, and per metre."""

HEADING_NOISE = 0.012
"""Doubt about the heading: radians per square root of a metre."""

TURN_NOISE = 0.02
"""Doubt about a turn: radians per square root of a radian."""

RANGE_SIGMA = 0.09
"""Doubt about a distance to a beacon, metres: the map's errors and the noise."""

STILL_SIGMA = 0.6
"""The same while the robot stands, when every reading says again what the last one said."""

GATE = 3.0
"""Standard deviations by which a reading may differ from what a beacon should give."""

FARTHEST = 0.4
"""Metres by which it may differ at most."""

AGREES = 0.35
"""Metres within which a reading speaks for the pose."""

REACH = 4.0
"""Metres within which walls are beacons, and beyond which a reading only says that none is."""

TILE = 1.0
"""Metres along a side of the squares for which the walls around are kept."""

_TANGENT = math.tan(CONE_HALF)


class BeaconTracker:
    """A pose and the doubts about it: x, y, heading, and how the heading drifts by the metre."""

    STATE: ClassVar[tuple[str, ...]] = ("_mean", "_covariance")

    def __init__(self, floor: Floor) -> None:
        doors = np.array([door.segment() for door in floor.doors.values()]).reshape(-1, 4)
        self._lines = np.concatenate([floor.walls, doors])
        self._first_door = len(floor.walls)
        self._around: dict[tuple[int, int], tuple[Floats, int]] = {}
        self._mean: Floats = np.zeros(4)
        self._covariance: Floats = np.zeros((4, 4))

    @property
    def pose(self) -> Pose:
        """x, y, heading."""
        x, y, theta, _ = self._mean.tolist()
        return (x, y, wrap(theta))

    @property
    def covariance(self) -> Floats:
        """Of x, y and the heading: shape (3, 3)."""
        return self._covariance[:3, :3]

    def place(self, pose: Pose, *, spread: float, turn_spread: float) -> None:
        """Begin anew at ``pose``, give or take."""
        self._mean = np.array([*pose, 0.0])
        self._covariance = np.diag([spread**2, spread**2, turn_spread**2, DRIFT**2])

    def widen(self, *, spread: float, turn_spread: float) -> None:
        """Doubt the pose more."""
        self._covariance = self._covariance + np.diag([spread**2, spread**2, turn_spread**2, 0.0])

    def move(self, motion: Motion) -> None:
        """Move as odometry says, less the drift."""
        metres = motion.metres
        turn = motion.turn - float(self._mean[3]) * metres
        heading = float(self._mean[2]) + turn / 2
        cos, sin = math.cos(heading), math.sin(heading)
        dx = motion.ahead * cos - motion.aside * sin
        dy = motion.ahead * sin + motion.aside * cos
        self._mean = self._mean + np.array([dx, dy, turn, 0.0])
        change = np.eye(4)
        change[0, 2], change[1, 2], change[2, 3] = -dy, dx, -metres
        along = METRE_NOISE**2 * metres + (SCALE_NOISE * metres) ** 2
        turning = HEADING_NOISE**2 * metres + TURN_NOISE**2 * abs(motion.turn)
        noise = np.zeros((4, 4))
        noise[0, 0], noise[1, 1] = along * cos * cos, along * sin * sin
        noise[0, 1] = noise[1, 0] = along * cos * sin
        noise[2, 2] = turning
        self._covariance = change @ self._covariance @ change.T + noise

    def sense(self, bearings: Floats, ranges: Floats, *, still: bool) -> Floats:
        """Take in readings (k,) of sonars at ``bearings``, all finite.

        Returns:
            1.0 for each that speaks for the pose as it was, 0.0 for the others.
        """
        look = self._mean[2] + bearings
        mounts = np.column_stack([np.cos(look), np.sin(look)]) * RING_RADIUS
        lines, walls = self._lines_around()
        if len(lines) == 0:
            return np.asarray(ranges >= REACH, dtype=np.float64)
        distance, toward, sharp = _nearest(lines, self._mean[:2] + mounts, look)
        opened = _pick(distance[:, :walls])
        shut = _pick(distance)
        rows = np.arange(len(ranges))
        seen = np.minimum(ranges, REACH)
        errors = [seen - np.minimum(distance[rows, pick], REACH) for pick in (opened, shut)]
        as_open = np.abs(errors[0]) <= np.abs(errors[1])
        chosen, surprise = np.where(as_open, opened, shut), np.where(as_open, *errors)
        usable = sharp[rows, chosen] & (ranges < REACH) & (np.abs(surprise) < FARTHEST)
        if usable.any():
            slopes = _slopes(toward[rows, chosen], mounts)[usable]
            self._update(slopes, surprise[usable], STILL_SIGMA if still else RANGE_SIGMA)
        return np.asarray(np.abs(surprise) < AGREES, dtype=np.float64)

    def _update(self, slopes: Floats, surprise: Floats, sigma: float) -> None:
        """One Kalman update by m distances; those beyond the gate are left out."""
        spread = slopes @ self._covariance
        expected = (spread * slopes).sum(axis=1) + sigma**2
        good = surprise**2 < GATE**2 * expected
        if not good.any():
            return
        slopes, surprise, spread = slopes[good], surprise[good], spread[good]
        noise = spread @ slopes.T + sigma**2 * np.eye(len(surprise))
        gain = np.linalg.solve(noise, spread).T
        self._mean = self._mean + gain @ surprise
        after = self._covariance - gain @ spread
        self._covariance = (after + after.T) / 2

    def _lines_around(self) -> tuple[Floats, int]:
        """Walls, then doors, near the pose, and how many of them are walls."""
        tile = (math.floor(self._mean[0] / TILE), math.floor(self._mean[1] / TILE))
        if tile not in self._around:
            x, y = (tile[0] + 0.5) * TILE, (tile[1] + 0.5) * TILE
            reach = REACH + TILE
            low = self._lines.reshape(-1, 2, 2).min(axis=1)
            high = self._lines.reshape(-1, 2, 2).max(axis=1)
            near = (low < (x + reach, y + reach)).all(axis=1)
            near &= (high > (x - reach, y - reach)).all(axis=1)
            self._around[tile] = (self._lines[near], int(near[: self._first_door].sum()))
        return self._around[tile]


def _pick(distance: Floats) -> NDArray[np.intp]:
    """The nearest line in each cone."""
    if distance.shape[1] == 0:
        return np.zeros(len(distance), dtype=np.intp)
    return np.asarray(distance.argmin(axis=1))


def _nearest(
    lines: Floats, sonars: Floats, look: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """The nearest point of each of m lines in the cone of each of k sonars.

    Returns:
        Distances (k, m), inf for none; unit vectors (k, m, 2) to the points; and whether a
        point is a beacon: met at right angles, or the end of its line.
    """
    cos, sin = np.cos(look)[:, None], np.sin(look)[:, None]
    ends = lines.reshape(-1, 2, 2)[None] - sonars[:, None, None]
    start_x = ends[..., 0, 0] * cos + ends[..., 0, 1] * sin
    start_y = ends[..., 0, 1] * cos - ends[..., 0, 0] * sin
    way_x = ends[..., 1, 0] * cos + ends[..., 1, 1] * sin - start_x
    way_y = ends[..., 1, 1] * cos - ends[..., 1, 0] * sin - start_y
    first, last = np.zeros_like(start_x), np.ones_like(start_x)
    for side in (-1.0, 1.0):
        inside = _TANGENT * start_x + side * start_y
        change = _TANGENT * way_x + side * way_y
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = -inside / change
        first = np.where(change > 0.0, np.maximum(first, crossing), first)
        last = np.where(change < 0.0, np.minimum(last, crossing), last)
        last = np.where((change == 0.0) & (inside < 0.0), -1.0, last)
    foot = -(start_x * way_x + start_y * way_y) / (way_x**2 + way_y**2)
    at = np.minimum(np.maximum(foot, first), last)
    x, y = start_x + at * way_x, start_y + at * way_y
    distance = np.where(first <= last, np.hypot(x, y), np.inf)
    sharp = (at == foot) | (at == 0.0) | (at == 1.0)
    away = np.maximum(np.hypot(x, y), 1e-6)
    toward = np.stack([(x * cos - y * sin) / away, (x * sin + y * cos) / away], axis=-1)
    return distance, toward, sharp


def _slopes(toward: Floats, mounts: Floats) -> Floats:
    """How distances change with x, y, heading and drift: shape (k, 4)."""
    slopes = np.zeros((len(toward), 4))
    slopes[:, :2] = -toward
    slopes[:, 2] = toward[:, 0] * mounts[:, 1] - toward[:, 1] * mounts[:, 0]
    return slopes
