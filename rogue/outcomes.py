"""What came of something that was done: of an effect, and of a whole step."""

from __future__ import annotations

import enum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict


class Outcome(BaseModel):
    """What came of an effect: a value, or a failure's name and sentence, with its data as value."""

    model_config = ConfigDict(frozen=True)

    value: dict[str, Any] = {}
    failure: str | None = None
    text: str = ""

    @property
    def failed(self) -> bool:
        """Whether the effect failed."""
        return self.failure is not None

    @property
    def reason(self) -> str:
        """Name and sentence of the failure."""
        return f"{self.failure}: {self.text}"


NOTHING = Outcome()
"""The outcome of an effect that has none."""


class Trouble(enum.StrEnum):
    """Why a step came to nothing, as far as it matters for what to do about it."""

    NOBODY = "nobody"
    """Nobody was there to answer."""
    IMPOSSIBLE = "impossible"
    """Somebody there said that it cannot be done."""
    BLOCKED = "blocked"
    """There is no way to the room now."""
    SHUT_IN = "shut_in"
    """The robot cannot get out of the room in which it is."""
    HINDERED = "hindered"
    """There is a way to the room, and the robot did not manage it this time."""
    UNSURE = "unsure"
    """Nothing could make sure that this is the room."""
    MISTAKEN = "mistaken"
    """What the step needs is not so in the world; the planner did not know."""
    UNWANTED = "unwanted"
    """Nobody wants it any more."""
    UNABLE = "unable"
    """The robot could not do it, and trying again is of no use."""


BELIEF, CAMERA, PERSON = LAYERS = ("belief", "camera", "person")
"""Names of our layers, which make sure of an arrival, cheap to costly."""


class Arrival(BaseModel):
    """What was found out when the robot had come somewhere.

    ``room`` is where it stands, None when nothing made sure of that; ``by`` is the name of the
    layer that did, after all layers before it had not, and ``sure`` how probable it is then.
    """

    model_config = ConfigDict(frozen=True)

    room: str | None = None
    by: str | None = None
    sure: float = 0.0


Thing = tuple[str, str]
"""An item on the tray: for which user, and what."""


class StepOutcome(BaseModel):
    """What came of an operator in the real world, and what it has changed there.

    ``room`` is where the robot is known to stand afterwards, None if nobody knows; ``placed`` and
    ``gone`` are the things that are on the tray now or not any more. A step that ended
    ``elsewhere`` or ``failed`` has not brought about what its operator predicts, for ``reason``.
    ``arrivals`` are what was found each time that the robot had come somewhere.
    """

    model_config = ConfigDict(frozen=True)

    kind: Literal["done", "elsewhere", "failed"]
    room: str | None = None
    reason: str | None = None
    trouble: Trouble | None = None
    placed: tuple[Thing, ...] = ()
    gone: tuple[Thing, ...] = ()
    arrivals: tuple[Arrival, ...] = ()
