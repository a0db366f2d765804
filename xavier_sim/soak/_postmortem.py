"""What somebody looks up who knows the truth, and asks why a drive failed."""

from __future__ import annotations

import enum
import math
from typing import Literal

from pydantic import BaseModel, ConfigDict

from xavier_sim.soak._way import Way

NEAR = 1.5
"""Metres of floor up to which people and carts count as near the robot."""

ASTRAY_FROM = 0.25
"""Metres between belief and truth above which the robot is astray."""

LAST_WHILE = 60.0
"""Seconds before the end of a drive for which is told how doors stood."""

LOST = "lost"
"""The reason of a navigator that says itself that it does not know where it is."""


class Company(BaseModel):
    """A person or cart near the robot and in its view.

    ``gap`` is the metres of floor between them, ``bearing`` the degrees from where the robot
    really looked, counter-clockwise positive.
    """

    model_config = ConfigDict(frozen=True)

    kind: Literal["person", "cart"]
    gap: float
    bearing: float


class Stray(enum.StrEnum):
    """How belief and truth parted."""

    BEFORE = "before"
    """They were apart when the drive began."""
    CARRIED = "carried"
    """The robot was put down elsewhere: it moved farther within a second than it can drive."""
    JUMPED = "jumped"
    """Belief did."""
    DRIFTED = "drifted"
    """Neither: bit by bit."""


class RoomDoor(BaseModel):
    """How a door of a room stood at the end of a drive, and for its last minute."""

    model_config = ConfigDict(frozen=True)

    name: str
    room: str
    is_open: bool
    last_minute: Way


class PostMortem(BaseModel):
    """The facts about a failed drive at its end: metres, seconds, degrees.

    ``x``, ``y`` and ``heading`` are where the robot really stood and looked, and ``space`` holds
    it; the same with ``believed_`` before it are its navigator's. Headings count from east,
    counter-clockwise. ``along`` and ``across`` are truth less belief in the direction of the longer
    side of ``space`` and square to it, positive east and north; ``turned`` is that of the heading.

    ``astray`` is for how long belief and truth had been more than 0.25 m apart; ``stray`` and
    ``strayed_in`` are how they parted, and the space in which the robot really was then; None if
    they did not. ``in_company`` is for how long somebody or something had been near; ``company``
    are those who are, the nearest first.
    ``doors`` are those of the rooms at both ends of the drive, and of the room ``blamed``, whose
    door the navigator says has ended the drive. ``lost`` is whether it said that it was lost.
    """

    model_config = ConfigDict(frozen=True)

    x: float
    y: float
    heading: float
    space: str | None
    believed_x: float
    believed_y: float
    believed_heading: float
    believed_space: str | None
    along: float
    across: float
    turned: float
    astray: float
    stray: Stray | None
    strayed_in: str | None
    doors: tuple[RoomDoor, ...]
    blamed: str | None
    company: tuple[Company, ...]
    in_company: float
    lost: bool

    @property
    def error(self) -> float:
        """Metres between belief and truth."""
        return math.hypot(self.along, self.across)
