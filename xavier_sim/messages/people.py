"""The people of the simulated office, and what they do without being asked."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Broadcast, Query

ItemAction = Literal["placed", "taken", "brought"]
"""Put on the robot's tray, taken from it, or brought to its user by somebody else."""


class Occupant(BaseModel):
    """Whoever works in a room: whether they are in, and whether they ever answer a robot."""

    model_config = ConfigDict(frozen=True)

    room: str
    present: bool
    answers: bool


class WhoIsIn(Query[Occupant]):
    """Ask about the one who works in a room: for people who look, and for tests."""

    wire_name = "xavierWhoIsIn"

    room: str = Field(max_length=64)


class MovePerson(Query[Occupant]):
    """Send the one who works in a room out, or back in; they stay until sent again."""

    wire_name = "xavierMovePerson"

    room: str = Field(max_length=64)
    present: bool


class ItemMoved(Broadcast):
    """Somebody has really put an item on the tray, taken one from it, or brought it by hand.

    ``room`` is where the robot stood then; empty in a corridor.
    """

    wire_name = "xavierItemMoved"

    user: str
    item: str
    room: str
    action: ItemAction
    time: float


class MoveItem(Query[ItemMoved]):
    """Somebody takes an item from the tray in passing, or brings it to its user by hand.

    Whoever is asked for it afterwards finds that it is not there. The answer is the `ItemMoved`
    that all hear.
    """

    wire_name = "xavierMoveItem"

    user: str = Field(min_length=1, max_length=64)
    item: str = Field(min_length=1, max_length=64)
    action: Literal["taken", "brought"]
