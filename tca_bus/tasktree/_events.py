"""What can happen to the task tree. Times are seconds since the epoch, by central's clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tca_bus._failure import Failure
from tca_bus._protocol import Outcome, SubmitTask
from tca_bus.tasktree._points import Point

LAST_SIBLING = ""
"""Stands for the sibling that was submitted last, whichever that is."""


@dataclass(frozen=True, slots=True)
class Submitted:
    """A module wants a new node.

    ``previous`` is the sibling that it comes after, ``waits`` the points of it that had not
    passed; the tree fills both in unless it is told.
    """

    time: float
    task: SubmitTask
    previous: str | None = LAST_SIBLING
    waits: tuple[Point, ...] = ()

    @property
    def id(self) -> str:
        """The id of the node."""
        return self.task.id


@dataclass(frozen=True, slots=True)
class Released:
    """A point of the top-level task before this one has passed.

    Recorded with the task that waited, since the other's records are not replayed once it ended.
    """

    time: float
    id: str
    previous: str
    point: Point


@dataclass(frozen=True, slots=True)
class Dispatched:
    """A try of a node was given to one incarnation of a module, which may not know yet."""

    time: float
    id: str
    attempt: int
    module: str
    incarnation: str


@dataclass(frozen=True, slots=True)
class Taken:
    """The module said that it works on the node."""

    time: float
    id: str
    attempt: int


@dataclass(frozen=True, slots=True)
class Reported:
    """The handler has ended."""

    time: float
    id: str
    attempt: int
    outcome: Outcome
    result: Any = None
    failure: Failure | None = None
    seen_failures: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class KillRequested:
    """Somebody wants the node and all below it gone, or only what is below it."""

    time: float
    id: str
    reason: str
    only_below: bool = False


@dataclass(frozen=True, slots=True)
class HandlerLost:
    """The module that had this try of the node is gone."""

    time: float
    id: str
    attempt: int
    module: str


@dataclass(frozen=True, slots=True)
class HandlerMissing:
    """No module came to handle the node within the time it may wait."""

    time: float
    id: str


@dataclass(frozen=True, slots=True)
class ProviderAppeared:
    """A module is there; ``capacities`` maps the messages it handles to how many at once.

    Said again for an incarnation that is known, it changes the capacities.
    """

    time: float
    module: str
    incarnation: str
    capacities: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class ProviderLost:
    """An incarnation of a module is gone for good."""

    time: float
    incarnation: str


RecordedEvent = (
    Submitted
    | Released
    | Dispatched
    | Taken
    | Reported
    | KillRequested
    | HandlerLost
    | HandlerMissing
)
"""Events that make the tree what it is: replayed in order they give the same tree."""

Event = RecordedEvent | ProviderAppeared | ProviderLost
