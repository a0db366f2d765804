"""The base's own reflex: it does not drive on into what it touches, or is about to touch.

It needs no driver, no planner and no map: it stands between whatever was commanded and the wheels,
at every control tick. A driver that is slow, silent or mistaken cannot overrule it.
"""

from __future__ import annotations

import math
from typing import Any

from xavier_sim.messages import (
    BUMP_PANELS,
    SONAR_COUNT,
    SONAR_NEAREST,
    SONAR_RING_RADIUS,
)
from xavier_sim.profile import TICK
from xavier_sim.robot import Reading

RIM = 0.305
"""Metres from the robot's centre to its rim."""

BRAKES = 1.0
"""Metres per second squared that the base brakes with for sure."""

LATENCY = 0.1
"""Seconds that pass before a command takes effect: a control tick."""

TOUCHING = SONAR_NEAREST + 0.02
"""A reading of the front sonar below this means that something is right before it, metres."""

WATCH = (0, 1, 2, SONAR_COUNT - 2, SONAR_COUNT - 1)
"""The sonars that look where the robot drives to: 30 degrees to either side."""

SIDE = math.cos(math.radians(60.0))
"""A panel faces the way that the robot drives when it is within 60 degrees of it."""

AHEAD = sum(1 << i for i in range(BUMP_PANELS) if math.cos(math.tau * i / BUMP_PANELS) > SIDE)
BEHIND = sum(1 << i for i in range(BUMP_PANELS) if math.cos(math.tau * i / BUMP_PANELS) < -SIDE)


class Reflex:
    """Lets a command through, or stops the wheels; told of every reading, in order.

    ``holds`` says whether it stopped the last command.
    """

    def __init__(self) -> None:
        self._rooms = dict.fromkeys(WATCH, math.inf)
        self._bump = 0
        self.holds = False

    def sense(self, reading: Reading) -> None:
        """Take in the reading of a tick."""
        self._bump = reading.bump
        way = max(0.0, reading.speed) * TICK
        for number in WATCH:
            if reading.sonar_fresh >> number & 1:
                self._rooms[number] = room_before(number, float(reading.sonar[number]))
            else:
                self._rooms[number] -= way

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"rooms": [self._rooms[number] for number in WATCH], "bump": self._bump}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot; None, as JSON has it, stands for no echo."""
        rooms = [math.inf if room is None else float(room) for room in state["rooms"]]
        self._rooms = dict(zip(WATCH, rooms, strict=True))
        self._bump = state["bump"]

    @property
    def room(self) -> float:
        """Metres that the robot can drive straight on before it meets what it has heard."""
        return min(self._rooms.values())

    def allow(self, speed: float, turn_rate: float) -> tuple[float, float]:
        """The command that may go to the wheels: this one, or a stop.

        Args:
            speed: wanted, m/s.
            turn_rate: wanted, rad/s.
        """
        pushes = self._bump & (AHEAD if speed > 0.0 else BEHIND if speed < 0.0 else 0)
        self.holds = bool(pushes) or (speed > 0.0 and needed(speed) > self.room)
        return (0.0, 0.0) if self.holds else (speed, turn_rate)


def room_before(number: int, echo: float) -> float:
    """Metres to drive straight on until the rim meets an echo on the axis of a sonar.

    Args:
        number: of the sonar.
        echo: metres from the ring; what is no range is no echo.
    """
    if not 0.0 <= echo < math.inf:
        return math.inf
    if number == 0 and echo < TOUCHING:
        return 0.0
    bearing, distance = math.tau * number / SONAR_COUNT, SONAR_RING_RADIUS + echo
    aside = distance * math.sin(bearing)
    if abs(aside) >= RIM:
        return math.inf
    return distance * math.cos(bearing) - math.sqrt(RIM * RIM - aside * aside)


def needed(speed: float) -> float:
    """Metres that the robot still covers once it is told to stop, at a speed in m/s."""
    return speed * LATENCY + speed * speed / (2.0 * BRAKES)
