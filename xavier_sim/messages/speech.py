"""The speech board and the keyboard on the robot's laptop."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Broadcast, Command

Subject = Literal["place", "placing", "taking", "where", "pickup", "deliver", "other"]
"""What a question can be about."""


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
    place, an item that somebody puts on the tray or takes from it there, or, asked of ``user``
    wherever they are, the room where their item is to be picked up or delivered. The command
    fails with ``no_answer`` when nobody answered for ``timeout`` seconds on the module's clock.
    """

    wire_name = "C_ask"
    on_module_lost = "resend"

    question: str = Field(min_length=1, max_length=1000)
    choices: tuple[str, ...] = ()
    about: Subject = "other"
    room: str | None = None
    user: str | None = None
    item: str | None = None
    timeout: float = Field(default=60.0, gt=0)


class Heard(Broadcast):
    """A sentence that the speech board has just said."""

    wire_name = "xavierHeard"

    text: str
    time: float
