"""What came of something that was done: of an effect, and of a whole step."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict


class Outcome(BaseModel):
    """What came of an effect: a value, or the name and the sentence of a failure."""

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


class StepOutcome(BaseModel):
    """What came of an operator in the real world.

    ``room`` is where the robot is known to stand afterwards, None if nobody knows. A step that
    ended ``elsewhere`` may be planned again from there; one that ``failed`` takes the requests
    that it served with it, for ``reason``.
    """

    model_config = ConfigDict(frozen=True)

    kind: Literal["done", "elsewhere", "failed"]
    room: str | None = None
    reason: str | None = None
