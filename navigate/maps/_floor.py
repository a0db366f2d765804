"""A floor as the navigator uses it: spaces, walls, doors, rooms and their places."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from itertools import chain

from navigate.maps._walls import Floats, Passage, map_passages, wall_segments
from navigate.messages import RoomLocation
from tca_bus import TcaError, near_matches, near_or_all
from xavier_sim.messages import FloorPlan, Space, SpaceKind

CENTIMETRES = 100.0
"""Map units (the papers' coordinates) in a metre."""

MOST_CELLS = 4096
"""Square metres of which it is kept which spaces have a part in them."""


class UnknownRoomError(TcaError, LookupError):
    """The map has no such room. ``room`` is what was asked for, ``near`` what looks like it."""

    exit_code = 2

    def __init__(self, room: str, known: list[str]) -> None:
        self.room, self.near = room, near_matches(room, known)
        super().__init__(f"the map has no room {room!r}.{near_or_all(room, known)}")


class Floor:
    """What follows from a floor plan."""

    def __init__(self, plan: FloorPlan) -> None:
        self.plan = plan
        self.spaces = {space.name: space for space in plan.spaces}
        self.passages = map_passages(plan)
        self.doors = {passage.name: passage for passage in self.passages if passage.door}
        self.places = {room: (at.x, at.y) for room, at in plan.places.items()}
        self._about = lru_cache(maxsize=MOST_CELLS)(self._spaces_about)
        self._open_beside = {name: self._opening_on(name) for name in self.spaces}

    @cached_property
    def walls(self) -> Floats:
        """The walls as an array (n, 4) of x0, y0, x1, y1 in metres."""
        return wall_segments(self.plan)

    def place(self, room: str) -> tuple[float, float]:
        """The point in metres at which the robot serves ``room``.

        Raises:
            UnknownRoomError: no such room.
        """
        try:
            return self.places[room.lower()]
        except KeyError:
            raise UnknownRoomError(room, sorted(self.places)) from None

    def location(self, room: str) -> RoomLocation:
        """The place of ``room`` in map units, to a tenth of one."""
        x, y = self.place(room)
        return RoomLocation(
            room=room.lower(), x=round(x * CENTIMETRES, 1), y=round(y * CENTIMETRES, 1)
        )

    def room_near(self, x: float, y: float, *, within: float = 0.5) -> str | None:
        """The room whose place is nearest to the point, if it is ``within`` metres."""
        best = min(self.places, key=lambda room: math.dist(self.places[room], (x, y)), default=None)
        return best if best and math.dist(self.places[best], (x, y)) <= within else None

    def space_at(self, x: float, y: float) -> Space | None:
        """The space that holds the point; the smallest, where they overlap."""
        about = self._about(math.floor(x), math.floor(y))
        holding = [space for space in about if inset(space, x, y) >= 0.0]
        return min(holding, key=_area, default=None)

    def space_nearest(self, x: float, y: float) -> Space:
        """The space that holds the point, or else the nearest one."""
        return self.space_at(x, y) or max(self.plan.spaces, key=lambda space: inset(space, x, y))

    def open_around(self, x: float, y: float, *, within: float) -> list[Space]:
        """The space of a point, and those that open on it and are less than ``within`` metres off.

        What stands in there can be heard and seen from the point; rooms have doors.
        """
        here = self.space_nearest(x, y)
        beside = self._open_beside[here.name]
        return [here, *(space for space in beside if inset(space, x, y) > -within)]

    def _spaces_about(self, x: int, y: int) -> list[Space]:
        """Those that have a part in the square metre from there."""
        return [
            space
            for space in self.plan.spaces
            if space.low.x <= x + 1 and space.high.x >= x
            and space.low.y <= y + 1 and space.high.y >= y
        ]  # fmt: skip

    def _opening_on(self, name: str) -> list[Space]:
        sides = [one.spaces for one in self.passages if not one.door and name in one.spaces]
        return [self.spaces[other] for other in dict.fromkeys(chain(*sides)) if other != name]

    def doorway_at(self, x: float, y: float, *, reach: float = 0.45) -> Passage | None:
        """The door in whose frame the point lies: ``reach`` metres before or behind its line."""
        for door in self.doors.values():
            ahead, aside = frame(door, x, y)
            if abs(ahead) < reach and abs(aside) < door.width / 2:
                return door
        return None

    def free(self, x: float, y: float, *, clearance: float = 0.3) -> bool:
        """Whether a robot fits there: in a space, ``clearance`` metres off every wall."""
        if self.space_at(x, y) is None:
            return False
        return clearance_of(self.walls, x, y) >= clearance


def clearance_of(walls: Floats, x: float, y: float) -> float:
    """Metres from a point to the nearest of the axis-parallel ``walls`` (n, 4)."""
    low_x, high_x = walls[:, [0, 2]].min(axis=1), walls[:, [0, 2]].max(axis=1)
    low_y, high_y = walls[:, [1, 3]].min(axis=1), walls[:, [1, 3]].max(axis=1)
    away_x = (low_x - x).clip(min=0.0) + (x - high_x).clip(min=0.0)
    away_y = (low_y - y).clip(min=0.0) + (y - high_y).clip(min=0.0)
    return float(((away_x**2 + away_y**2) ** 0.5).min(initial=math.inf))


def inset(space: Space, x: float, y: float) -> float:
    """How far inside the rectangle a point is, in metres; negative outside."""
    return min(x - space.low.x, space.high.x - x, y - space.low.y, space.high.y - y)


def frame(door: Passage, x: float, y: float) -> tuple[float, float]:
    """A point in the frame of a door: metres beyond its line along the normal, and left."""
    (cx, cy), (nx, ny) = door.centre, door.normal
    return (x - cx) * nx + (y - cy) * ny, (y - cy) * nx - (x - cx) * ny


def is_room(space: Space) -> bool:
    """Whether a space is an office behind a door."""
    return space.kind is SpaceKind.ROOM


def _area(space: Space) -> float:
    return (space.high.x - space.low.x) * (space.high.y - space.low.y)
