"""The speech board and the keyboard on the robot's laptop."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Broadcast, Command


class Spoken(BaseModel):
    """That a sentence was said, and when (simulated seconds since the epoch)."""

    model_config = ConfigDict(frozen=True)

    text: str
    time: float


class Say(Command[Spoken]):
    """Say a sentence through the speech board."""

    wire_name = "C_say"
    on_module_lost = "resend"

    text: str = Field(min_length=1, max_length=1000)


class Typed(BaseModel):
    """What somebody typed on the keyboard, and when."""

    model_config = ConfigDict(frozen=True)

    answer: str
    time: float


class Ask(Command[Typed]):
    """Wait for an answer on the keyboard.

    ``choices`` are the answers that are accepted, such as ("y", "n") or ("y", "i"); without
    choices any line is. ``about`` and ``room`` tell what the question is about: the robot's
    place, or an item that somebody puts on the tray or takes from it there. The command fails
    with ``no_answer`` when nobody answered for ``timeout`` seconds on the module's clock.
    """

    wire_name = "C_ask"
    on_module_lost = "resend"

    question: str = Field(min_length=1, max_length=1000)
    choices: tuple[str, ...] = ()
    about: Literal["place", "placing", "taking", "where", "other"] = "other"
    room: str | None = None
    user: str | None = None
    item: str | None = None
    timeout: float = Field(default=60.0, gt=0)


class Heard(Broadcast):
    """A sentence that the speech board has just said."""

    wire_name = "xavierHeard"

    text: str
    time: float


class ItemMoved(Broadcast):
    """Somebody has really put an item on the tray, or really taken one from it."""

    wire_name = "xavierItemMoved"

    user: str
    item: str
    room: str
    action: Literal["placed", "taken"]
    time: float
