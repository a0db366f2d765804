"""What the task tree wants done after an event."""

from __future__ import annotations

from dataclasses import dataclass

from tca_bus._attachments import Sending
from tca_bus._protocol import TaskStatus
from tca_bus.tasktree._events import RecordedEvent


@dataclass(frozen=True, slots=True)
class Record:
    """Write the event into the journal before any later effect is carried out."""

    root: str
    name: str
    event: RecordedEvent


@dataclass(frozen=True, slots=True)
class Dispatch:
    """Give this try of the node to one incarnation of a module."""

    id: str
    attempt: int
    module: str
    incarnation: str


@dataclass(frozen=True, slots=True)
class Cancel:
    """Tell the module to stop its handler; the node ends when the handler has reported.

    Come back with `Abandoned` if it has not reported within ``grace`` wall seconds.
    """

    id: str
    attempt: int
    module: str
    incarnation: str
    reason: str
    grace: float


@dataclass(frozen=True, slots=True)
class Publish:
    """Show the changed status of a node."""

    status: TaskStatus


@dataclass(frozen=True, slots=True)
class WaitForHandler:
    """Come back with `HandlerMissing` if the wait ``number`` of the node lasts ``seconds``."""

    id: str
    number: int
    seconds: float


@dataclass(frozen=True, slots=True)
class SetAlarm:
    """Come back with `Alarmed` at the time ``when`` of central's clock, if it is still wanted.

    A ``passive`` alarm does not make simulated time move in lockstep: a deadline, not a delay.
    """

    id: str
    key: str
    when: float
    passive: bool


@dataclass(frozen=True, slots=True)
class Tell:
    """Send an inform or broadcast, once."""

    sending: Sending


@dataclass(frozen=True, slots=True)
class Freed:
    """A node ended and was freed; the history keeps its last status."""

    root: str
    status: TaskStatus


@dataclass(frozen=True, slots=True)
class Ended:
    """A top-level task ended, or an attachment to a message: its records are history."""

    root: str
    time: float


Effect = Record | Dispatch | Cancel | Publish | WaitForHandler | SetAlarm | Tell | Freed | Ended
