"""What a procedure asks of the world, and what it hears back.

A procedure is a synchronous generator: it yields effects and is sent an `Outcome` for each, so
that it can be tested without a bus and run again from its start with recorded outcomes.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TypeVar

from navigate.messages import NavigateToGoal, NoticeLandmark, SetPosition
from rogue.outcomes import Outcome, StepOutcome
from xavier_sim.messages import Ask, Say

TaskOfRobot = NavigateToGoal | NoticeLandmark | SetPosition | Say | Ask


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
class Look:
    """Have the camera read the door plate, when so many seconds have passed."""

    after: float = 0.0


@dataclass(frozen=True, slots=True)
class CheckTray:
    """See whether an item is on the tray, as far as anybody has noticed."""

    user: str
    item: str


@dataclass(frozen=True, slots=True)
class AwaitCharge:
    """Stand at the charger until the battery is so full, 0 to 1."""

    charge: float


@dataclass(frozen=True, slots=True)
class Perform:
    """Have a goal or a command carried out."""

    message: TaskOfRobot


Effect = Tell | Locate | Believe | Look | CheckTray | AwaitCharge | Perform

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Urgency:
    """How the tasks of a step are sent: their priority, and when they are of no use any more.

    ``deadline`` is in seconds since the epoch on the module's clock, None for no such time.
    """

    priority: int = 0
    deadline: float | None = None


AT_LEISURE = Urgency()

Part = Generator[Effect, Outcome, T]
"""A part of a procedure that comes to a ``T``."""

Procedure = Generator[Effect, Outcome, StepOutcome]
