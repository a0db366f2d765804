"""Where the robot is sent next: anywhere at random, or in and out of every door in turn."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from xavier_sim.floors import FloorError, door_room
from xavier_sim.messages import Door, FloorPlan
from xavier_sim.noise import restore_stream, stream, stream_state

BEFORE_DOOR = 1.2
"""Metres before a door, on the middle of its opening, to which the robot drives out."""

OUTSIDE = "before "
"""What the name of such a goal begins with; the name of its room follows."""

FEWEST_PLACES = 2
"""Places that errands between places need."""


class Goal(NamedTuple):
    """A point in metres, the space that it lies in, and the name that a report gives it."""

    name: str
    x: float
    y: float
    space: str


def room_of(goal: str) -> str:
    """The room that a goal of that name lies in or, by the door, before."""
    return goal.removeprefix(OUTSIDE)


class Errands(Protocol):
    """Goals one after the other."""

    def next(self, here: str | None) -> Goal | None:
        """The next goal for a robot that is in the space ``here``; None after the last."""
        ...

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        ...

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        ...


class RandomErrands:
    """Rooms at random without end, never the one in which the robot stands.

    Raises:
        FloorError: there are fewer than two.
    """

    def __init__(self, plan: FloorPlan, seed: int) -> None:
        if len(plan.places) < FEWEST_PLACES:
            expected = f"{FEWEST_PLACES} or more, for errands between them"
            raise FloorError(plan.name, "number of places", len(plan.places), expected)
        self._goals = [Goal(room, at.x, at.y, room) for room, at in sorted(plan.places.items())]
        self._random = stream(seed, "soak-errands")

    def next(self, here: str | None) -> Goal | None:
        """Any room but ``here``."""
        goals = [goal for goal in self._goals if goal.space != here]
        return goals[int(self._random.integers(len(goals)))] if goals else None

    def snapshot(self) -> dict[str, Any]:
        """The state of the random numbers."""
        return {"random": stream_state(self._random)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        restore_stream(self._random, state["random"])


class DoorTrials:
    """Into every room and out again, a number of times."""

    def __init__(self, plan: FloorPlan, times: int) -> None:
        spaces = {space.name: space for space in plan.spaces}
        doors = {door_room(door, spaces): door for door in reversed(plan.doors)}
        self._goals = [
            goal
            for room, at in sorted(plan.places.items())
            if room in doors
            for goal in [Goal(room, at.x, at.y, room), _outside(plan, doors[room], room)] * times
        ]
        self._done = 0

    def next(self, here: str | None) -> Goal | None:
        """The next of them, wherever the robot is."""
        del here
        if self._done == len(self._goals):
            return None
        self._done += 1
        return self._goals[self._done - 1]

    def snapshot(self) -> dict[str, Any]:
        """How many were given out."""
        return {"done": self._done}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self._done = state["done"]


def _outside(plan: FloorPlan, door: Door, room: str) -> Goal:
    """The point before a door, on the line from the place of its room through the door."""
    inside, at = plan.places[room], door.at
    away_x, away_y = at.x - inside.x, at.y - inside.y
    along_x = abs(away_x) > abs(away_y)
    x = at.x + (BEFORE_DOOR if away_x > 0 else -BEFORE_DOOR) * along_x
    y = at.y + (BEFORE_DOOR if away_y > 0 else -BEFORE_DOOR) * (not along_x)
    other = next(name for name in door.between if name != room)
    return Goal(f"{OUTSIDE}{room}", x, y, other)
