"""A floor plan: named rectangular spaces joined by doors and openings.

The simulator builds its walls from one, the navigator is given another with the errors that a
survey makes. Everything is in metres, x east, y north.
"""

from __future__ import annotations

import enum

from pydantic import BaseModel, ConfigDict, Field


class SpaceKind(enum.StrEnum):
    """What a space is for."""

    CORRIDOR = "corridor"
    """A way between rooms."""
    FOYER = "foyer"
    """A wide place where corridors meet."""
    LOUNGE = "lounge"
    """A place where people sit."""
    ROOM = "room"
    """An office behind a door."""


class Corner(BaseModel):
    """A point in metres."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    x: float = Field(allow_inf_nan=False)
    y: float = Field(allow_inf_nan=False)


class Space(BaseModel):
    """An axis-parallel rectangle of free floor.

    Where two spaces that are not rooms touch, the floor is open between them; a room is closed
    by walls all round but for its doors.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(pattern=r"^[a-z][a-z0-9-]*$")
    kind: SpaceKind
    low: Corner
    high: Corner


class Door(BaseModel):
    """A door in the wall that two spaces share, ``width`` metres wide round ``at``."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(pattern=r"^[a-z][a-z0-9-]*$")
    between: tuple[str, str]
    at: Corner
    width: float = Field(default=0.9, gt=0.3, le=3.0)


class FloorPlan(BaseModel):
    """A whole floor, with the point of each room where the robot stands to serve it.

    ``places`` maps a room to the point just inside its door that `navigateToG` drives to;
    ``charger`` is where the robot charges its battery, if anywhere.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    spaces: tuple[Space, ...]
    doors: tuple[Door, ...]
    places: dict[str, Corner]
    start: Corner
    start_heading: float = Field(default=0.0, allow_inf_nan=False)
    charger: Corner | None = None
