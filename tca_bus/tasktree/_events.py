"""What can happen to the task tree. Times are seconds since the epoch, by central's clock."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tca_bus._attachments import Attachment, Catch, Resolution, Tap
from tca_bus._failure import Failure
from tca_bus._orders import Order, Point
from tca_bus._protocol import Outcome, SubmitTask, TaskClass

LAST_SIBLING = ""
"""Stands for the sibling that was submitted last, whichever that is."""


class Role(enum.StrEnum):
    """Why a node is where it is in the tree."""

    STEP = "step"
    """Sent by a handler, or at the root: the nominal plan."""
    GATE = "gate"
    """The listener of a blocking tap; its parent waits for it at a point."""
    LISTENER = "listener"
    """The listener of a tap that holds nothing."""
    RECOVERY = "recovery"
    """An exception handler at work on its parent's failure."""
    ACTION = "action"
    """What a monitor, its parent, does when it fires."""
    CLEAN_UP = "clean-up"
    """What is done when its parent was killed or failed; a kill of the parent spares it."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a node comes from that central sent itself.

    ``of`` is the node that it belongs to, ``attachment`` the tap, catch or clean-up that it is
    sent for, ``gate`` the point that waits for it.
    """

    role: Role = Role.STEP
    of: str | None = None
    attachment: str | None = None
    gate: Point | None = None


@dataclass(frozen=True, slots=True)
class Submitted:
    """A module wants a new node.

    ``previous`` is the sibling that it comes after, ``waits`` the points of it that had not
    passed, ``taps`` those on its message; the tree fills them in unless it is told.
    """

    time: float
    task: SubmitTask
    previous: str | None = LAST_SIBLING
    waits: tuple[Point, ...] = ()
    origin: Origin = field(default_factory=Origin)
    taps: tuple[Tap, ...] = ()

    @property
    def id(self) -> str:
        """The id of the node."""
        return self.task.id


@dataclass(frozen=True, slots=True)
class Prepared:
    """A module wants a place for a task that it sends later."""

    time: float
    id: str
    name: str
    task_class: TaskClass
    sender: str
    parent: str | None = None
    previous: str | None = LAST_SIBLING
    taps: tuple[Tap, ...] = ()


@dataclass(frozen=True, slots=True)
class Constrained:
    """The node's point ``order.then`` has to wait for another."""

    time: float
    order: Order

    @property
    def id(self) -> str:
        """The id of the node that has to wait."""
        return self.order.then.task


@dataclass(frozen=True, slots=True)
class Released:
    """A point of a node of another top-level task has passed, for which this one waited.

    Recorded with the task that waited, since the other's records are not replayed once it ended.
    ``delay`` is what the constraint adds.
    """

    time: float
    id: str
    previous: str
    point: Point
    delay: float = 0.0


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
    resolution: Resolution | None = None


@dataclass(frozen=True, slots=True)
class Abandoned:
    """The handler did not stop within its grace; it is waited for no longer."""

    time: float
    id: str
    attempt: int


@dataclass(frozen=True, slots=True)
class Alarmed:
    """A time has come for which the node waited; ``key`` tells its alarms apart."""

    time: float
    id: str
    key: str


@dataclass(frozen=True, slots=True)
class Suspended:
    """Nothing at or below the node is given to a handler any more."""

    time: float
    id: str


@dataclass(frozen=True, slots=True)
class Resumed:
    """The node is suspended no longer."""

    time: float
    id: str


@dataclass(frozen=True, slots=True)
class Prioritized:
    """The node has another priority."""

    time: float
    id: str
    priority: int


@dataclass(frozen=True, slots=True)
class Retried:
    """Somebody wants the node handled again, from the start."""

    time: float
    id: str


@dataclass(frozen=True, slots=True)
class Triggered:
    """The condition of a monitor is satisfied, for the ``number``-th time of this attempt."""

    time: float
    id: str
    attempt: int
    number: int
    data: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class CaughtFailure:
    """An exception handler was found for the node's failure, on itself or above."""

    time: float
    id: str
    catch: Catch
    context: str
    invocation: int


@dataclass(frozen=True, slots=True)
class UncaughtFailure:
    """No exception handler takes the node's failure."""

    time: float
    id: str


@dataclass(frozen=True, slots=True)
class Attached:
    """Something was attached to the node."""

    time: float
    id: str
    what: Attachment


@dataclass(frozen=True, slots=True)
class Detached:
    """An attachment was taken away from the node."""

    time: float
    id: str
    attachment: str


@dataclass(frozen=True, slots=True)
class Registered:
    """Something was attached to all tasks of a message."""

    time: float
    message: str
    what: Attachment

    @property
    def id(self) -> str:
        """The id of the attachment; its records are its own."""
        return self.what.id


@dataclass(frozen=True, slots=True)
class Deregistered:
    """An attachment to a message is gone."""

    time: float
    id: str


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
    """An incarnation of a module is gone for good; ``module`` is its name."""

    time: float
    incarnation: str
    module: str = ""


NodeEvent = (
    Constrained
    | Released
    | Dispatched
    | Taken
    | Reported
    | Abandoned
    | Alarmed
    | Suspended
    | Resumed
    | Prioritized
    | Retried
    | Triggered
    | CaughtFailure
    | UncaughtFailure
    | Attached
    | Detached
    | HandlerLost
    | HandlerMissing
)
"""Events on a node that is there."""

RecordedEvent = Submitted | Prepared | KillRequested | Registered | Deregistered | NodeEvent
"""Events that make the tree what it is: replayed in order they give the same tree."""

Event = RecordedEvent | ProviderAppeared | ProviderLost
