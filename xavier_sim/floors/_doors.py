"""The doors of a floor as they stand: open or shut, by the name of their room or their own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from tca_bus import TcaError, near_matches, near_or_all
from xavier_sim.floors._geometry import Floats, Geometry, segment_distances


class UnknownDoorError(TcaError, LookupError):
    """The floor has no door of that name and no room with a door."""

    exit_code = 2

    def __init__(self, name: str, known: list[str]) -> None:
        self.name = name
        self.near = near_matches(name, known)
        hint = near_or_all(name, known)
        super().__init__(f"there is no room or door {name!r} on this floor.{hint}")


class DoorStanding(NamedTuple):
    """A door by its own name, the room that it belongs to, and whether it is open."""

    name: str
    room: str
    is_open: bool


class Doors:
    """How each door of a floor stands; all are open to begin with."""

    def __init__(self, geometry: Geometry) -> None:
        self._geometry = geometry
        self._index = {name: i for i, name in reversed(list(enumerate(geometry.door_rooms)))}
        self._index.update({name: i for i, name in enumerate(geometry.door_names)})
        self.is_open = [True] * len(geometry.door_names)
        self._told_of: list[bool] = []
        self._told: list[DoorStanding] = []

    def find(self, name: str) -> int:
        """The number of the door of a room, or of a door by its own name.

        Raises:
            UnknownDoorError: there is neither a room nor a door of that name.
        """
        if name not in self._index:
            raise UnknownDoorError(name, list(self._index))
        return self._index[name]

    def standing(self, door: int) -> DoorStanding:
        """How a door stands, by its number."""
        geometry = self._geometry
        return DoorStanding(
            geometry.door_names[door], geometry.door_rooms[door], self.is_open[door]
        )

    def each(self) -> list[DoorStanding]:
        """How every door stands; the same list until one moves."""
        if self._told_of != self.is_open:
            self._told_of = self.is_open.copy()
            self._told = [self.standing(door) for door in range(len(self.is_open))]
        return self._told

    def by_room(self) -> dict[str, bool]:
        """Whether a door is open, by the room that it belongs to: any, if that has several."""
        states: dict[str, bool] = {}
        for door in self.each():
            states[door.room] = states.get(door.room, False) or door.is_open
        return states

    def distances(self, x: float, y: float) -> Floats:
        """Metres from a point to each door."""
        return segment_distances(self._geometry.doors, x, y)

    def near(self, x: float, y: float, within: float) -> str | None:
        """The room of the door nearest to a point, None when it is farther than ``within``."""
        distances = self.distances(x, y)
        if distances.size == 0:
            return None
        nearest = int(distances.argmin())
        return self._geometry.door_rooms[nearest] if distances[nearest] <= within else None

    def clearance(self, x: float, y: float) -> float:
        """Metres from a point to the nearest wall or shut door."""
        walls = segment_distances(self._geometry.walls, x, y).min(initial=float("inf"))
        shut = [not is_open for is_open in self.is_open]
        return float(self.distances(x, y)[shut].min(initial=walls))

    def snapshot(self) -> dict[str, bool]:
        """Whether each door is open, by its own name."""
        return dict(zip(self._geometry.door_names, self.is_open, strict=True))

    def restore(self, state: Mapping[str, bool]) -> None:
        """Go back to a snapshot; a door that it does not know is open."""
        self.is_open = [state.get(name, True) for name in self._geometry.door_names]
