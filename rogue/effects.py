"""What a procedure asks of the world, and what it hears back.

A procedure is a synchronous generator: it yields effects and is sent an `Outcome` for each, so
that it can be tested without a bus and run again from its start with recorded outcomes.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from navigate.messages import NavigateToGoal, SetPosition
from xavier_sim.messages import Ask, Say

TaskOfRobot = NavigateToGoal | SetPosition | Say | Ask


@dataclass(frozen=True, slots=True)
class Tell:
    """Print one line of the conversation."""

    line: str


@dataclass(frozen=True, slots=True)
class Locate:
    """Ask the navigator for the map location of a room."""

    room: str


@dataclass(frozen=True, slots=True)
class Believe:
    """Ask the navigator where it believes to be."""


@dataclass(frozen=True, slots=True)
class Perform:
    """Have a goal or a command carried out."""

    message: TaskOfRobot


@dataclass(frozen=True, slots=True)
class Pause:
    """Let the world go on for a while, in seconds on the module's clock."""

    seconds: float


Effect = Tell | Locate | Believe | Perform | Pause


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


Procedure = Generator[Effect, Outcome, StepOutcome]
