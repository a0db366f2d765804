"""What stood in the way lately: remembered for a while, and planned around."""

from __future__ import annotations

from typing import ClassVar

from navigate.maps import Point
from navigate.routes._routes import Hindrances

REMEMBER = 180.0
"""Seconds for which a shut door or a blocked place is planned around."""

CERTAIN = 20.0
"""Seconds for which it is not even worth a look where there is no other way."""


class Memory:
    """Shut doors and blocked places with the time they were seen."""

    STATE: ClassVar[tuple[str, ...]] = ("_seen",)

    def __init__(self) -> None:
        self._doors: dict[str, float] = {}
        self._points: dict[Point, float] = {}

    def shut(self, door: str, now: float) -> None:
        """Remember that a door was found shut."""
        self._doors[door] = now

    def opened(self, door: str) -> None:
        """Forget it: the robot has just passed."""
        self._doors.pop(door, None)

    def blocked(self, at: Point, now: float) -> None:
        """Remember that something stands in the way."""
        self._points[at] = now

    def forget_since(self, when: float) -> None:
        """Forget what was seen from ``when`` on: the robot was not where it believed to be."""
        self._doors = {name: at for name, at in self._doors.items() if at < when}
        self._points = {spot: at for spot, at in self._points.items() if at < when}

    def believed(self, now: float, *, age: float = REMEMBER) -> Hindrances:
        """What was seen within ``age`` seconds; what is older than `REMEMBER` is dropped."""
        self._doors = {name: at for name, at in self._doors.items() if now - at < REMEMBER}
        self._points = {spot: at for spot, at in self._points.items() if now - at < REMEMBER}
        return Hindrances(
            frozenset(name for name, at in self._doors.items() if now - at < age),
            tuple(spot for spot, at in self._points.items() if now - at < age),
        )

    @property
    def _seen(self) -> dict[str, list[list[float | str]]]:
        return self.snapshot()

    @_seen.setter
    def _seen(self, state: dict[str, list[list[float | str]]]) -> None:
        self.restore(state)

    def snapshot(self) -> dict[str, list[list[float | str]]]:
        """What `restore` needs."""
        return {
            "doors": [[name, at] for name, at in self._doors.items()],
            "points": [[x, y, at] for (x, y), at in self._points.items()],
        }

    def restore(self, state: dict[str, list[list[float | str]]]) -> None:
        """Go back to a snapshot."""
        self._doors = {str(name): float(at) for name, at in state["doors"]}
        self._points = {(float(x), float(y)): float(at) for x, y, at in state["points"]}
