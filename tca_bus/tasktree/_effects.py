"""What the task tree wants done after an event."""

from __future__ import annotations

from dataclasses import dataclass

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
    """Tell the module to stop its handler; the node ends when the handler has reported."""

    id: str
    attempt: int
    module: str
    incarnation: str
    reason: str


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
class Ended:
    """A top-level task ended and its nodes were freed; these are their last statuses."""

    root: str
    statuses: tuple[TaskStatus, ...]


Effect = Record | Dispatch | Cancel | Publish | WaitForHandler | Ended
