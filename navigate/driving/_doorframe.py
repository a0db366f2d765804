"""A door seen from near: its place in the robot's odometry, measured on the jambs.

The nearest thing in a sonar's cone beside an opening is the tip of a jamb. Its distance is exact
however wide the cone is, so the ranges to the two jambs give the middle of the door to a few
centimetres, which neither the map nor the position estimate does. A Kalman filter over the two
coordinates of the middle takes them in one by one.
"""

from __future__ import annotations

import math

import numpy as np

from navigate.body import BEARINGS, CONE_HALF, NEAREST, RING_RADIUS, Pose, fresh_sonars, wrap
from navigate.driving._view import View
from navigate.maps import Floats, Passage

MIDDLE_SIGMA = 0.09
"""Doubt about the middle of a door before it is measured, metres: map and position estimate."""

JAMB_SIGMA = 0.045
"""Doubt about a range to a jamb, metres: noise, and the rays' spacing in the cone."""

GATE = 0.2
"""Metres by which a range may differ from what the jamb should give."""

SURE = CONE_HALF - math.radians(2.0)
"""A jamb nearer than this to a sonar's axis is in its cone for sure."""

FARTHEST_JAMB = 1.5


class DoorFrame:
    """The frame of a door as the robot passes it in one direction.

    Args:
        door: the passage, from the map.
        sign: 1.0 to pass from its first space to its second, -1.0 the other way.
        view: the tick at which the manoeuvre begins.
    """

    def __init__(self, door: Passage, sign: float, view: View) -> None:
        self.door = door
        nx, ny = door.normal[0] * sign, door.normal[1] * sign
        turned = view.odom[2] - view.pose[2]
        self.heading = wrap(math.atan2(ny, nx) + turned)
        self._ahead = np.array([math.cos(self.heading), math.sin(self.heading)])
        self._left = np.array([-self._ahead[1], self._ahead[0]])
        self.middle = _transfer(door.centre, view.pose, view.odom)
        self.covariance = np.eye(2) * MIDDLE_SIGMA**2

    def locate(self, odom: Pose) -> tuple[float, float, float]:
        """The robot in the frame: metres beyond the line, metres to the left, radians turned."""
        away = np.array(odom[:2]) - self.middle
        ahead, left = float(away @ self._ahead), float(away @ self._left)
        return ahead, left, wrap(odom[2] - self.heading)

    @property
    def doubt(self) -> float:
        """Standard deviation across the opening, metres."""
        return math.sqrt(float(self._left @ self.covariance @ self._left))

    def measure(self, view: View) -> None:
        """Take in the fresh readings that come from a jamb."""
        for number in fresh_sonars(view.fresh):
            if NEAREST + 0.01 < view.ranges[number] < FARTHEST_JAMB:
                self._take_in(view.odom, float(BEARINGS[number]), float(view.ranges[number]))

    def _take_in(self, odom: Pose, bearing: float, reading: float) -> None:
        axis = odom[2] + bearing
        sonar = np.array(odom[:2]) + RING_RADIUS * np.array([math.cos(axis), math.sin(axis)])
        tips = [self.middle + side * self.door.width / 2 * self._left for side in (-1.0, 1.0)]
        seen = [tip - sonar for tip in tips if _in_cone(tip - sonar, axis)]
        if not seen:
            return
        nearest = min(seen, key=lambda away: float(away @ away))
        distance = math.hypot(*nearest)
        if abs(reading - distance) < GATE:
            self._update(nearest / distance, reading - distance)

    def _update(self, direction: Floats, surprise: float) -> None:
        """Kalman update of the middle by one range along ``direction``."""
        spread = self.covariance @ direction
        gain = spread / (float(direction @ spread) + JAMB_SIGMA**2)
        self.middle = self.middle + gain * surprise
        self.covariance = self.covariance - np.outer(gain, spread)


def _in_cone(away: Floats, axis: float) -> bool:
    return abs(wrap(math.atan2(away[1], away[0]) - axis)) < SURE


def _transfer(point: tuple[float, float], pose: Pose, odom: Pose) -> Floats:
    """A point of the map in odometry coordinates, by the believed pose."""
    turn = odom[2] - pose[2]
    dx, dy = point[0] - pose[0], point[1] - pose[1]
    cos, sin = math.cos(turn), math.sin(turn)
    return np.array([odom[0] + dx * cos - dy * sin, odom[1] + dx * sin + dy * cos])
