"""Finding the facts of a post-mortem on a floor that is known as it is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from xavier_sim.body import wrap
from xavier_sim.floors import build_geometry, space_at
from xavier_sim.messages import FloorPlan, SpaceKind
from xavier_sim.soak._contract import Pose
from xavier_sim.soak._postmortem import NEAR, Company, RoomDoor
from xavier_sim.soak._way import Way

Point = tuple[float, float]

Segments = NDArray[np.float64]


class Upright(Protocol):
    """Somebody or something that stands on the floor, a disc in metres."""

    @property
    def x(self) -> float:
        """Metres east."""
        ...

    @property
    def y(self) -> float:
        """Metres north."""
        ...

    @property
    def radius(self) -> float:
        """Metres."""
        ...

    @property
    def person(self) -> bool:
        """Whether it is somebody."""
        ...


class Examiner:
    """Looks up what lies where on a floor, and who is near a robot.

    Args:
        plan: the floor as it is.
        radius: of the robot, metres.
    """

    def __init__(self, plan: FloorPlan, radius: float) -> None:
        self._plan, self._radius = plan, radius
        self._geometry = build_geometry(plan)
        self._spaces = {space.name: space for space in plan.spaces}

    def space(self, at: Point) -> str | None:
        """The space that holds a point."""
        space = space_at(self._plan, *at)
        return space.name if space else None

    def along_and_across(self, space: str | None, error: Point) -> Point:
        """An error split along the longer side of a space, and square to it."""
        east, north = error
        if space is None:
            return east, north
        low, high = self._spaces[space].low, self._spaces[space].high
        return (east, north) if high.x - low.x >= high.y - low.y else (north, east)

    def near(
        self, at: Point, around: Iterable[Upright], is_open: Mapping[str, bool]
    ) -> list[Upright]:
        """Those within `NEAR` of a robot with neither a wall nor a shut door in between."""
        close = [one for one in around if self._gap(at, one) <= NEAR]
        if not close:
            return close
        shut = [not is_open[name] for name in self._geometry.door_names]
        barriers = np.concatenate([self._geometry.walls, self._geometry.doors[shut]])
        return [one for one in close if not crossed(barriers, at, (one.x, one.y))]

    def company(
        self, pose: Pose, around: Iterable[Upright], is_open: Mapping[str, bool]
    ) -> tuple[Company, ...]:
        """Those who are near, the nearest first."""
        at = pose[:2]
        found = [
            Company(
                kind="person" if one.person else "cart",
                gap=round(self._gap(at, one), 3),
                bearing=degrees(math.atan2(one.y - at[1], one.x - at[0]) - pose[2]),
            )
            for one in self.near(at, around, is_open)
        ]
        return tuple(sorted(found, key=lambda one: one.gap))

    def doors(
        self, spaces: Iterable[str | None], is_open: Mapping[str, bool], moved: Iterable[str]
    ) -> tuple[RoomDoor, ...]:
        """The doors of the rooms among some spaces.

        Args:
            spaces: names of any spaces.
            is_open: how every door stands.
            moved: the doors that stood otherwise not long ago.
        """
        rooms = {name for name in spaces if name and self._is_room(name)}
        return tuple(
            RoomDoor(
                name=door.name,
                room=room,
                is_open=is_open[door.name],
                last_minute=_way(is_open=is_open[door.name], moved=door.name in moved),
            )
            for door in self._plan.doors
            for room in door.between
            if room in rooms
        )

    def _is_room(self, name: str) -> bool:
        return name in self._spaces and self._spaces[name].kind is SpaceKind.ROOM

    def _gap(self, at: Point, one: Upright) -> float:
        return math.hypot(one.x - at[0], one.y - at[1]) - one.radius - self._radius


def crossed(barriers: Segments, one: Point, other: Point) -> bool:
    """Whether the straight line between two points crosses a segment, shape (n, 4)."""
    first, last = barriers[:, :2], barriers[:, 2:]
    apart = _side(first, last, one) * _side(first, last, other) < 0.0
    along = np.array(other) - np.array(one)
    from_first, from_last = first - np.array(one), last - np.array(one)
    sides = (along[0] * from_first[:, 1] - along[1] * from_first[:, 0]) * (
        along[0] * from_last[:, 1] - along[1] * from_last[:, 0]
    )
    return bool(np.any(apart & (sides < 0.0)))


def degrees(angle: float) -> float:
    """An angle in radians as degrees between -180 and 180, to a tenth."""
    return round(math.degrees(wrap(angle)), 1)


def _side(first: Segments, last: Segments, at: Point) -> Segments:
    """On which side of each line a point lies: positive, negative, or 0 on it."""
    along, off = last - first, np.array(at) - first
    side: Segments = along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]
    return side


def _way(*, is_open: bool, moved: bool) -> Way:
    if moved:
        return Way.CHANGING
    return Way.OPEN if is_open else Way.SHUT
