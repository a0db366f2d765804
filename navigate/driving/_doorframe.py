"""A door seen from near: its place in the robot's odometry, measured on wall and jambs.

Neither the map nor the position estimate knows the middle of a door to a few centimetres; what
the robot senses on its way does. The nearest thing in a sonar's cone beside an opening is the tip
of a jamb, whose distance is exact however wide the cone is. A laser sees where the wall ends. A
Kalman filter over the middle and the heading of the door takes them in one by one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from navigate.body import (
    BEARINGS,
    CONE_HALF,
    NEAREST,
    RING_RADIUS,
    STRIPER,
    Laser,
    Pose,
    Sight,
    fresh_sonars,
    wrap,
)
from navigate.driving._doorsight import look_at_door
from navigate.driving._view import View
from navigate.maps import Floats, Passage

MIDDLE_SIGMA, HEADING_SIGMA = 0.12, math.radians(2.0)
"""Doubt about a door before it is measured, metres and radians: map and position estimate."""

JAMB_SIGMA = 0.045
"""Doubt about a range to a jamb, metres: noise, and the rays' spacing in the cone."""

EDGE_SIGMA = 0.02
"""Doubt about where a striper sees the wall end, metres: half the spacing of its beams; that of
other lasers is as their spacing."""

WALL_SIGMA = 0.03
"""Doubt about a point of the wall that a laser sees, metres; neighbours err alike."""

GATE_SIGMAS, GATE = 3.0, 0.25
"""By how much a reading may differ from what it should be: sigmas, and metres at most."""

DRIFT_METRES, DRIFT_HEADING, DRIFT_TURN = 0.02, math.radians(0.8), math.radians(1.2)
"""What dead reckoning errs by: metres and radians for each root of a metre that was driven, and
radians for each root of a radian that was turned."""

SURE = CONE_HALF - math.radians(2.0)
"""A jamb nearer than this to a sonar's axis is in its cone for sure."""

FARTHEST_JAMB = 1.5

LEAST_TOLD = 1.0 / math.radians(6.0) ** 2
"""What wall and jambs must tell of the heading to be passed on: one over a doubt squared."""


class Look(NamedTuple):
    """Which way the robot looks on the map, and the doubt about that: radians."""

    theta: float
    doubt: float


class DoorFrame:
    """The frame of a door as the robot passes it in one direction.

    Args:
        door: the passage, from the map.
        sign: 1.0 to pass from its first space to its second, -1.0 the other way.
        view: the tick at which the manoeuvre begins.
        heading_sigma: doubt about the robot's heading then, radians.
    """

    def __init__(
        self, door: Passage, sign: float, view: View, *, heading_sigma: float = HEADING_SIGMA
    ) -> None:
        self.door, self.sign = door, sign
        nx, ny = door.normal[0] * sign, door.normal[1] * sign
        heading = wrap(math.atan2(ny, nx) + view.odom[2] - view.pose[2])
        middle = _transfer(door.centre, view.pose, view.odom)
        self._state = np.array([*middle, heading])
        self._odom = view.odom
        self._covariance = np.diag([MIDDLE_SIGMA**2, MIDDLE_SIGMA**2, 0.0])
        self._told, self._told_variance = heading, 0.0
        self._doubt_heading(heading_sigma)

    @property
    def middle(self) -> Floats:
        """The middle of the opening in odometry coordinates, shape (2,)."""
        return self._state[:2]

    @property
    def heading(self) -> float:
        """The direction straight through, radians in odometry coordinates."""
        return float(self._state[2])

    def locate(self, odom: Pose) -> tuple[float, float, float]:
        """The robot in the frame: metres beyond the line, metres to the left, radians turned."""
        ahead, left = self._axes()
        away = np.array(odom[:2]) - self.middle
        return float(away @ ahead), float(away @ left), wrap(odom[2] - self.heading)

    def orient(self, odom: Pose) -> Look | None:
        """Which way the robot looks on the map, by wall and jambs alone.

        What the frame was told at first is the localizer's own heading, and is taken out again.
        None where little was measured.
        """
        variance = float(self._covariance[2, 2])
        told = 1.0 / variance - 1.0 / self._told_variance
        if told <= LEAST_TOLD:
            return None
        measured = self._told + wrap(self.heading - self._told) / (variance * told)
        through = math.atan2(self.sign * self.door.normal[1], self.sign * self.door.normal[0])
        return Look(wrap(through + odom[2] - measured), math.sqrt(1.0 / told))

    @property
    def doubt(self) -> float:
        """Standard deviation across the opening, metres."""
        left = np.array([*self._axes()[1], 0.0])
        return math.sqrt(float(left @ self._covariance @ left))

    def measure(self, view: View) -> None:
        """Take in how far the robot has moved, and the new readings of wall and jambs."""
        self._drift(view.odom)
        for number in fresh_sonars(view.fresh):
            if NEAREST + 0.01 < view.ranges[number] < FARTHEST_JAMB:
                self._hear(view.odom, float(BEARINGS[number]), float(view.ranges[number]))
        for laser, sight in view.sights:
            self._see(view.odom, laser, sight)

    def _drift(self, odom: Pose) -> None:
        metres = math.dist(odom[:2], self._odom[:2])
        turn = abs(wrap(odom[2] - self._odom[2]))
        self._odom = odom
        self._covariance[0, 0] += DRIFT_METRES**2 * metres
        self._covariance[1, 1] += DRIFT_METRES**2 * metres
        self._doubt_heading(math.sqrt(DRIFT_HEADING**2 * metres + DRIFT_TURN**2 * turn))

    def _doubt_heading(self, sigma: float) -> None:
        """Doubt where the robot looks, by so many radians: the door turns about the robot."""
        dx, dy = self.middle - np.array(self._odom[:2])
        swing = np.array([-dy, dx, 1.0])
        self._told_variance += sigma**2
        self._covariance += sigma**2 * np.outer(swing, swing)

    def _hear(self, odom: Pose, bearing: float, reading: float) -> None:
        """A sonar's range to the nearer of the jambs in its cone."""
        axis = odom[2] + bearing
        sonar_x = odom[0] + RING_RADIUS * math.cos(axis)
        sonar_y = odom[1] + RING_RADIUS * math.sin(axis)
        x, y, heading = self._state.tolist()
        left_x, left_y = -math.sin(heading), math.cos(heading)
        seen = list[tuple[Floats, float]]()
        for side in (-1.0, 1.0):
            half = side * self.door.width / 2
            away_x, away_y = x + half * left_x - sonar_x, y + half * left_y - sonar_y
            if abs(wrap(math.atan2(away_y, away_x) - axis)) < SURE:
                seen.append((np.array([away_x, away_y]), half))
        if not seen:
            return
        away, side = min(seen, key=lambda tip: float(tip[0] @ tip[0]))
        distance = math.hypot(*away)
        unit = away / distance
        change = np.array([*unit, -side * float(unit @ self._axes()[0])])
        self._take_in(change, reading - distance, JAMB_SIGMA)

    def _see(self, odom: Pose, laser: Laser, sight: Sight) -> None:
        """What a laser sees of the wall, and where it ends."""
        ahead, left = self._axes()
        seen = look_at_door(self.locate(odom), laser, sight.ranges)
        spacing = laser.spacing / STRIPER.spacing
        for along in seen.wall:
            # Of a point of the wall its distance from the line is known to be none.
            change = np.array([*-ahead, float(along[1])])
            self._take_in(change, -float(along[0]), WALL_SIGMA)
        for side, ends in ((-1.0, seen.right_jambs), (1.0, seen.left_jambs)):
            for end in ends:
                change = np.array([*-left, 0.0])
                self._take_in(change, side * self.door.width / 2 - end, EDGE_SIGMA * spacing)

    def _take_in(self, change: Floats, surprise: float, sigma: float) -> None:
        """Kalman update by one number that grows by ``change`` with the state."""
        spread = self._covariance @ change
        doubt = float(change @ spread) + sigma**2
        if abs(surprise) > min(GATE, GATE_SIGMAS * math.sqrt(doubt)):
            return
        gain = spread / doubt
        self._state = self._state + gain * surprise
        self._covariance = self._covariance - np.outer(gain, spread)

    def _axes(self) -> tuple[Floats, Floats]:
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return np.array([cos, sin]), np.array([-sin, cos])


def _transfer(point: tuple[float, float], pose: Pose, odom: Pose) -> Floats:
    """A point of the map in odometry coordinates, by the believed pose."""
    turn = odom[2] - pose[2]
    dx, dy = point[0] - pose[0], point[1] - pose[1]
    cos, sin = math.cos(turn), math.sin(turn)
    return np.array([odom[0] + dx * cos - dy * sin, odom[1] + dx * sin + dy * cos])
