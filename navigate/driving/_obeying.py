"""Whether the wheels do as they are told: an empty battery or a pressed stop holds them still."""

from __future__ import annotations

import math

from navigate.body import Pose, wrap
from navigate.driving._view import View, Wheels

STILL_SECONDS = 10.0
"""How long the wheels may be told to move and not turn."""

MOVED, TURNED = 0.02, 0.05
"""Metres and radians of odometry that show that they turn."""

LEAST_SPEED, LEAST_TURN = 0.05, 0.1
"""Metres and radians per second below which a command need not show within that time."""


class ObedienceWatch:
    """Compares what the wheels were told with what odometry says that they did."""

    def __init__(self) -> None:
        self._since: float | None = None
        self._from: Pose = (0.0, 0.0, 0.0)

    def told(self, wheels: Wheels, view: View) -> None:
        """Take in what the wheels are told at a tick.

        A base that does not drive on into what its sonars hear right ahead is no matter of this.
        """
        asks_little = abs(wheels.speed) < LEAST_SPEED and abs(wheels.turn) < LEAST_TURN
        if asks_little or (wheels.speed > 0.0 and view.close_ahead):
            self._since = None
        elif self._since is None or self._has_moved(view):
            self._since, self._from = view.time, view.odom

    def stood(self, view: View) -> float:
        """Seconds for which the wheels have stood by now though told to move."""
        if self._since is None or self._has_moved(view):
            return 0.0
        return view.time - self._since

    def forget(self) -> None:
        """Begin anew."""
        self._since = None

    def _has_moved(self, view: View) -> bool:
        metres = math.dist(view.odom[:2], self._from[:2])
        return metres > MOVED or abs(wrap(view.odom[2] - self._from[2])) > TURNED
