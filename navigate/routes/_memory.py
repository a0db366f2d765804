"""What stood in the way lately: remembered for a while, and planned around."""

from __future__ import annotations

import math
from typing import ClassVar

from navigate.maps import Point
from navigate.routes._hindrances import Hindrances

REMEMBER = 180.0
"""Seconds for which a shut door or a blocked place is planned around."""

CERTAIN = 20.0
"""Seconds for which it is not even worth a look where there is no other way."""

FADING = 240.0
"""Seconds in which the probability that it still is so falls to a third."""

FORGOTTEN = 900.0
"""Seconds after which it is of no account any more."""

SHUT_COSTS, BLOCKED_COSTS = 60.0, 120.0
"""Seconds lost before a door that is shut still, and before a corridor that is blocked still."""


class Memory:
    """Shut doors and blocked places with the time they were seen."""

    STATE: ClassVar[tuple[str, ...]] = ("_seen",)

    def __init__(self) -> None:
        self._doors: dict[str, float] = {}
        self._glimpsed: dict[str, float] = {}
        self._points: dict[Point, float] = {}

    def shut(self, door: str, now: float) -> None:
        """Remember that a door was found shut."""
        self._doors[door] = now
        self._glimpsed.pop(door, None)

    def glimpse(self, door: str, now: float) -> None:
        """Remember that a door looked shut in passing: likely, and never for certain."""
        self._glimpsed[door] = now

    def opened(self, door: str) -> None:
        """Forget it: the robot has just passed through, or by it."""
        self._doors.pop(door, None)
        self._glimpsed.pop(door, None)

    def blocked(self, at: Point, now: float) -> None:
        """Remember that something stands in the way."""
        self._points[at] = now

    def forget_since(self, when: float) -> None:
        """Forget what was seen from ``when`` on: the robot was not where it believed to be."""
        self._doors = {name: at for name, at in self._doors.items() if at < when}
        self._glimpsed = {name: at for name, at in self._glimpsed.items() if at < when}
        self._points = {spot: at for spot, at in self._points.items() if at < when}

    def believed(self, now: float, *, age: float = REMEMBER) -> Hindrances:
        """What was met within ``age`` seconds, as if it were so still; not what was glimpsed."""
        self._forget(now)
        return Hindrances(
            frozenset(name for name, at in self._doors.items() if now - at < age),
            tuple(spot for spot, at in self._points.items() if now - at < age),
        )

    def outlook(self, now: float, *, way_is_free: bool = False) -> Hindrances:
        """What to reckon with: what was just seen is so still, the rest with some probability.

        Args:
            now: seconds.
            way_is_free: that no place is taken for blocked for sure, for want of another way.
        """
        self._forget(now)
        certain = 0.0 if way_is_free else CERTAIN
        doors, points = self._doors.items(), self._points.items()
        certainly = frozenset(name for name, at in doors if now - at < CERTAIN)
        # What was glimpsed of a door is later than what was met at it.
        likely = {name: at for name, at in doors if now - at >= CERTAIN} | self._glimpsed
        return Hindrances(
            certainly,
            tuple(spot for spot, at in points if now - at < certain),
            tuple((name, SHUT_COSTS * still_so(now - at)) for name, at in likely.items()),
            tuple(
                (spot, BLOCKED_COSTS * still_so(now - at))
                for spot, at in points
                if now - at >= certain
            ),
        )

    def _forget(self, now: float) -> None:
        self._doors = {name: at for name, at in self._doors.items() if now - at < FORGOTTEN}
        self._glimpsed = {d: at for d, at in self._glimpsed.items() if now - at < FORGOTTEN}
        self._points = {spot: at for spot, at in self._points.items() if now - at < FORGOTTEN}

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
            "glimpsed": [[name, at] for name, at in self._glimpsed.items()],
            "points": [[x, y, at] for (x, y), at in self._points.items()],
        }

    def restore(self, state: dict[str, list[list[float | str]]]) -> None:
        """Go back to a snapshot."""
        self._doors = {str(name): float(at) for name, at in state["doors"]}
        # States that older versions kept have none.
        glimpsed = state.get("glimpsed", [])
        self._glimpsed = {str(name): float(at) for name, at in glimpsed}
        self._points = {(float(x), float(y)): float(at) for x, y, at in state["points"]}


def still_so(age: float) -> float:
    """The probability that what was seen ``age`` seconds ago is so still."""
    return math.exp(-max(0.0, age) / FADING)
