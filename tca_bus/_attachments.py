"""What can be attached to a task, or to all tasks of a message: taps, catches, clean-ups.

Sources: TCA's ``tcaTapMessage``, ``tcaTapReference`` and ``tcaAddExceptionHandler``; TCM's
``OnTermination``.
"""

from __future__ import annotations

import enum
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from tca_bus._orders import Point
from tca_bus._traits import TaskTraits

ATTACHMENT_ID_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._:+-]{0,119}$"

ANY = "*"
"""Stands for every message, or every exception."""


class TapCondition(enum.StrEnum):
    """When a tap fires. The seven blocking ones hold the tapped task until the listener is done."""

    WHEN_SENT = "WhenSent"
    BEFORE_HANDLING = "BeforeHandling"
    WHILE_HANDLING = "WhileHandling"
    AFTER_HANDLED = "AfterHandled"
    AFTER_REPLIED = "AfterReplied"
    AFTER_SUCCESS = "AfterSuccess"
    AFTER_FAILURE = "AfterFailure"
    BEFORE_ACHIEVING = "BeforeAchieving"
    WHILE_ACHIEVING = "WhileAchieving"
    AFTER_ACHIEVED = "AfterAchieved"
    WHEN_ACHIEVED = "WhenAchieved"
    BEFORE_PLANNING = "BeforePlanning"
    WHILE_PLANNING = "WhilePlanning"
    AFTER_PLANNED = "AfterPlanned"
    WHEN_PLANNED = "WhenPlanned"
    WHEN_SUCCESS = "WhenSuccess"
    WHEN_FAILURE = "WhenFailure"
    WHEN_KILLED = "WhenKilled"


GATES: dict[TapCondition, Point] = {
    TapCondition.BEFORE_HANDLING: Point.START_HANDLING,
    TapCondition.BEFORE_PLANNING: Point.START_PLANNING,
    TapCondition.BEFORE_ACHIEVING: Point.START_ACHIEVING,
    TapCondition.WHEN_SUCCESS: Point.END_HANDLING,
    TapCondition.WHEN_PLANNED: Point.END_PLANNING,
    TapCondition.WHEN_ACHIEVED: Point.END_ACHIEVING,
    TapCondition.WHEN_FAILURE: Point.START_RECOVERY,
}
"""The blocking conditions, each with the point that it holds."""

FOLLOWERS: dict[Point, tuple[TapCondition, ...]] = {
    Point.START_HANDLING: (TapCondition.WHILE_HANDLING,),
    Point.START_PLANNING: (TapCondition.WHILE_PLANNING,),
    Point.START_ACHIEVING: (TapCondition.WHILE_ACHIEVING,),
    Point.END_HANDLING: (TapCondition.AFTER_HANDLED, TapCondition.AFTER_SUCCESS),
    Point.END_PLANNING: (TapCondition.AFTER_PLANNED,),
    Point.END_ACHIEVING: (TapCondition.AFTER_ACHIEVED,),
    Point.START_RECOVERY: (TapCondition.AFTER_HANDLED, TapCondition.AFTER_FAILURE),
}
"""The conditions that hold nothing: they fire when the point has passed."""

BLOCKING = frozenset({*GATES, TapCondition.WHEN_KILLED})
"""The conditions whose listener is waited for."""

OF_TASKS = frozenset(set(TapCondition) - {TapCondition.AFTER_REPLIED})
"""The conditions that make sense for goals, commands and monitors."""

OF_MESSAGES = frozenset(
    {
        TapCondition.WHEN_SENT,
        TapCondition.BEFORE_HANDLING,
        TapCondition.WHILE_HANDLING,
        TapCondition.AFTER_HANDLED,
        TapCondition.AFTER_REPLIED,
    }
)
"""The conditions that make sense for queries, informs and broadcasts."""


class Sending(BaseModel):
    """A message that central sends on behalf of somebody, by wire name."""

    model_config = ConfigDict(frozen=True)

    name: str
    task_class: Literal["goal", "command", "inform", "broadcast"]
    revision: int = 1
    data: dict[str, Any] = Field(default_factory=dict)
    priority: int = 0
    traits: TaskTraits = TaskTraits()


class Tap(BaseModel):
    """A listener that gets a message when something tapped comes to a point.

    ``payload`` says what the listener is given: the tapped message's own data (for
    ``AfterReplied`` the reply), as in TCA, or a `TapNotice`. ``on_failure`` is what becomes of the
    tapped task when the listener of a blocking tap fails, dies or is not there: it goes on
    ("ignore"), or fails too ("fail"), as a safety interlock wants.
    """

    model_config = ConfigDict(frozen=True)

    kind: Literal["tap"] = "tap"
    id: str = Field(pattern=ATTACHMENT_ID_PATTERN)
    condition: TapCondition
    listener: Sending
    payload: Literal["data", "notice"] = "data"
    on_failure: Literal["ignore", "fail"] = "ignore"
    owner: str = ""
    incarnation: str = ""

    @property
    def is_blocking(self) -> bool:
        """Whether the tapped task waits for the listener."""
        return self.condition in BLOCKING


class TapNotice(BaseModel):
    """What a tap tells its listener of the tapped message."""

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="constants")

    condition: TapCondition
    message: str
    data: dict[str, Any] = Field(default_factory=dict)
    sender: str = ""
    task: str | None = None
    reply: Any = None
    failure: dict[str, Any] | None = None


class Catch(BaseModel):
    """An exception handler on a task, or on all tasks of a message.

    ``exception`` is the name of the failures that it takes, those of its subclasses among them;
    ``*`` takes all. ``handler`` is the name under which a module serves it. It is invoked at most
    ``max_invocations`` times; 0 is without limit.
    """

    model_config = ConfigDict(frozen=True)

    kind: Literal["catch"] = "catch"
    id: str = Field(pattern=ATTACHMENT_ID_PATTERN)
    exception: str = ANY
    handler: str
    max_invocations: int = Field(default=0, ge=0)
    owner: str = ""
    incarnation: str = ""


class CleanUp(BaseModel):
    """What is sent when a task that has begun ends by failure or kill.

    The task ends after it, however long it takes; a kill of the task spares it.
    """

    model_config = ConfigDict(frozen=True)

    kind: Literal["clean_up"] = "clean_up"
    id: str = Field(pattern=ATTACHMENT_ID_PATTERN)
    sending: Sending


Attachment = Annotated[Tap | Catch | CleanUp, Field(discriminator="kind")]


class Caught(BaseModel):
    """What an exception handler is given of the failure and of the tasks around it.

    ``failed`` and ``context`` are the ids of the task that failed and of the one on which the
    handler was found; ``retries`` is how often the failed task was tried again before.
    """

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="constants")

    failure: dict[str, Any]
    failed: str
    failed_name: str
    failed_data: dict[str, Any]
    context: str
    context_name: str
    retries: int
    context_retries: int
    invocation: int


class Resolution(BaseModel):
    """What an exception handler decided.

    ``repaired``: the failed task counts as done. ``retry``: run ``task`` again, the failed one or
    one above it, unless it was tried again ``most`` times already; then it is as a bypass.
    ``bypass``: let the search for a handler go on.
    """

    model_config = ConfigDict(frozen=True)

    action: Literal["repaired", "retry", "bypass"] = "repaired"
    task: str | None = None
    most: int = Field(default=3, ge=1)
