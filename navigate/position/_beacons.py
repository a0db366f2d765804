"""Tracking a pose by walls and corners: an extended Kalman filter over odometry and sonar.

Beside the pose it learns how the odometry errs as a rule: how the heading drifts by the metre, by
what share a metre is counted too long, and by what share a turn. So a wheel that slips or pulls to
one side is made up for after some metres. After Leonard & Durrant-Whyte (1991) for the beacons, and
Martinelli, Tomatis & Siegwart, Simultaneous localization and odometry self calibration for mobile
robot (2007), for the augmented state.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from navigate.body import Motion, Pose, wrap
from navigate.maps import Floats, Floor
from navigate.position._walls_met import REACH, Flags, Nearest, WallsMet

ERRS: Floats = np.array([0.012, 0.06, 0.02])
"""Doubt at the start about drift (radians per metre), and about the shares of metre and turn."""

MOST_ERRS: Floats = np.array([0.06, 0.3, 0.1])
"""What they can be at most."""

CHANGES: Floats = np.array([0.0006, 0.002, 0.0005])
"""How they may change by the metre: per square root of a metre."""

METRE_NOISE = 0.03
"""Doubt about a distance: metres per square root of a metre."""

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

_SIZE = 6
_UNCHANGED: Floats = np.eye(_SIZE)


class BeaconTracker:
    """A pose, the errors of the odometry, and the doubts about both.

    Motions are taken in as they come; what they add to the doubts is reckoned when the next
    readings are, some ticks later.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_mean", "_covariance", "_way")

    def __init__(self, floor: Floor) -> None:
        self._walls = WallsMet(floor)
        self._mean: Floats = np.zeros(_SIZE)
        self._covariance: Floats = np.diag([0.0, 0.0, 0.0, *ERRS**2])
        self._way = (0.0, 0.0, 0.0, 0.0, 0.0)
        # Doubts are asked for many times a tick and change every few: a new covariance is a new
        # array, by which it is known.
        self._deviations, self._reckoned_of = (0.0, 0.0), np.empty(0)

    @property
    def pose(self) -> Pose:
        """x, y, heading."""
        x, y, theta = self._mean[:3].tolist()
        return (x, y, wrap(theta))

    @property
    def errs(self) -> tuple[float, float, float]:
        """Radians of drift a metre, and the shares by which a metre and a turn are overcounted."""
        drift, metre, turn = self._mean[3:].tolist()
        return (drift, metre, turn)

    @property
    def covariance(self) -> Floats:
        """Of x, y and the heading: shape (3, 3)."""
        return self._covariance[:3, :3]

    @property
    def deviations(self) -> tuple[float, float]:
        """Standard deviations of the position in metres, and of the heading in radians."""
        if self._reckoned_of is not self._covariance:
            x, y, theta = self._covariance.diagonal()[:3].tolist()
            self._deviations = math.sqrt(x + y), math.sqrt(theta)
            self._reckoned_of = self._covariance
        return self._deviations

    def place(self, pose: Pose, *, spread: float, turn_spread: float) -> None:
        """Begin anew at ``pose``, give or take; what is known of the wheels stays known."""
        self._forget_way()
        self._mean = np.concatenate([pose, self._mean[3:]])
        errs = self._covariance[3:, 3:]
        self._covariance = np.diag([spread**2, spread**2, turn_spread**2, 0.0, 0.0, 0.0])
        self._covariance[3:, 3:] = errs

    def widen(self, *, spread: float, turn_spread: float) -> None:
        """Doubt the pose more."""
        more = [spread**2, spread**2, turn_spread**2, 0.0, 0.0, 0.0]
        self._covariance = self._covariance + np.diag(more)

    def move(self, motion: Motion) -> None:
        """Move as odometry says, less its errors."""
        x, y, theta, drift, metre, turning = self._mean.tolist()
        metres = motion.metres
        turn = motion.turn * (1.0 - turning) - drift * metres
        heading = theta + turn / 2
        cos, sin = math.cos(heading), math.sin(heading)
        dx = motion.ahead * cos - motion.aside * sin
        dy = motion.ahead * sin + motion.aside * cos
        kept = 1.0 - metre
        self._mean[:3] = (x + kept * dx, y + kept * dy, theta + turn)
        along_x, along_y, far, turned, around = self._way
        self._way = (
            along_x + dx, along_y + dy, far + metres, turned + motion.turn,
            around + abs(motion.turn),
        )  # fmt: skip

    @property
    def metres(self) -> float:
        """How far the robot has moved since doubts were last reckoned."""
        return self._way[2]

    def settle(self) -> None:
        """Reckon what the motions have added to the doubts."""
        dx, dy, metres, turned, around = self._way
        if metres == around == 0.0:
            return
        change = _UNCHANGED.copy()
        change[0, 2], change[1, 2] = -dy, dx
        change[0, 4], change[1, 4] = -dx, -dy
        change[2, 3], change[2, 5] = -metres, -turned
        after = change @ self._covariance @ change.T
        length = max(math.hypot(dx, dy), 1e-9)
        cos, sin, along = dx / length, dy / length, METRE_NOISE**2 * metres
        after[0, 0] += along * cos * cos
        after[1, 1] += along * sin * sin
        after[0, 1] += along * cos * sin
        after[1, 0] += along * cos * sin
        after[2, 2] += HEADING_NOISE**2 * metres + TURN_NOISE**2 * around
        spread = after.diagonal()[3:]
        after[(3, 4, 5), (3, 4, 5)] = np.minimum(spread + CHANGES**2 * metres, ERRS**2)
        self._covariance = after
        self._forget_way()

    def sense(self, sonars: Floats, ranges: Floats, *, still: bool) -> Floats:
        """Take in k readings, all finite.

        Args:
            sonars: where each was taken, and in which direction, in the frame of the robot as it
                stands now: shape (k, 3).
            ranges: metres, shape (k,).
            still: whether the robot stands.

        Returns:
            1.0 for each that speaks for the pose as it was, 0.0 for the others.
        """
        self.settle()
        x, y, theta = self._mean[:3].tolist()
        cos, sin = math.cos(theta), math.sin(theta)
        aside_x = sonars[:, 0] * cos - sonars[:, 1] * sin
        aside_y = sonars[:, 0] * sin + sonars[:, 1] * cos
        look = sonars[:, 2] + theta
        there = np.empty((len(ranges), 3))
        there[:, 0], there[:, 1], there[:, 2] = x + aside_x, y + aside_y, look
        opened, shut = self._walls.nearest(there)
        seen = np.minimum(ranges, REACH)
        as_open, as_shut = (seen - np.minimum(met.distance, REACH) for met in (opened, shut))
        is_open = np.abs(as_open) <= np.abs(as_shut)
        surprise = np.where(is_open, as_open, as_shut)
        off = np.abs(surprise)
        usable = np.where(is_open, opened.sharp, shut.sharp) & (ranges < REACH) & (off < FARTHEST)
        if usable.any():
            toward_x, toward_y = _toward(opened, shut, is_open, look)
            slopes = np.empty((len(ranges), 3))
            slopes[:, 0], slopes[:, 1] = -toward_x, -toward_y
            slopes[:, 2] = toward_x * aside_y - toward_y * aside_x
            self._update(slopes[usable], surprise[usable], STILL_SIGMA if still else RANGE_SIGMA)
        return (off < AGREES).astype(np.float64)

    def orient(self, theta: float, *, spread: float) -> None:
        """Take in which way the robot looks, radians, unless that is far from what is believed."""
        self.settle()
        off = wrap(theta - float(self._mean[2]))
        doubt = float(self._covariance[2, 2]) + spread**2
        if off**2 > GATE**2 * doubt:
            return
        gain = self._covariance[:, 2] / doubt
        self._mean = self._mean + gain * off
        self._covariance = self._covariance - doubt * np.outer(gain, gain)
        self._mean[3:] = np.minimum(np.maximum(self._mean[3:], -MOST_ERRS), MOST_ERRS)

    def _update(self, slopes: Floats, surprise: Floats, sigma: float) -> None:
        """One Kalman update by m distances, all as good; those beyond the gate are left out."""
        pose = self._covariance[:3, :3]
        expected = ((slopes @ pose) * slopes).sum(axis=1) + sigma**2
        good = surprise**2 < GATE**2 * expected
        if not good.any():
            return
        slopes, surprise = slopes[good], surprise[good]
        told = slopes.T @ slopes / sigma**2
        pull = slopes.T @ surprise / sigma**2
        # The information form: distances are many, but depend on three numbers only.
        wanted = np.empty((3, 4))
        wanted[:, :3], wanted[:, 3] = told, pull
        solved = np.linalg.solve(_UNCHANGED[:3, :3] + told @ pose, wanted)
        spread = self._covariance[:, :3]
        self._mean = self._mean + spread @ solved[:, 3]
        after = self._covariance - spread @ solved[:, :3] @ spread.T
        self._covariance = (after + after.T) / 2
        self._mean[3:] = np.minimum(np.maximum(self._mean[3:], -MOST_ERRS), MOST_ERRS)

    def _forget_way(self) -> None:
        self._way = (0.0, 0.0, 0.0, 0.0, 0.0)


def _toward(opened: Nearest, shut: Nearest, is_open: Flags, look: Floats) -> tuple[Floats, Floats]:
    """The directions on the map in which what is met lies: x and y, shape (k,) each."""
    ahead = np.where(is_open, opened.ahead, shut.ahead)
    aside = np.where(is_open, opened.aside, shut.aside)
    away = np.maximum(np.hypot(ahead, aside), 1e-6)
    cos, sin = np.cos(look), np.sin(look)
    return (ahead * cos - aside * sin) / away, (ahead * sin + aside * cos) / away
