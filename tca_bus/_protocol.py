"""What modules and central say to each other: queries of their own, readable like any other.

A module submits a task to central and gets an acknowledgement; central asks the handling
module to take it; that module reports the outcome to central. Each of these may be sent again
without harm: tasks are told apart by id, tries of one task by their attempt number.
"""

from __future__ import annotations

import enum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from tca_bus._attachments import Attachment, Resolution
from tca_bus._failure import Failure
from tca_bus._log_statements import Statement
from tca_bus._messages import ModuleLostPolicy, Query, UnhandledPolicy
from tca_bus._monitor_spec import MonitorSpec
from tca_bus._orders import TASK_ID_PATTERN, Order
from tca_bus._trace_context import TRACEPARENT_PATTERN
from tca_bus._traits import TaskTraits

CENTRAL = "central"
"""The name of the module that keeps the task tree."""

TaskClass = Literal["goal", "command", "monitor", "exception"]
"""What a node of the task tree is; an exception node is a handler at work on a failure."""

KILL_GRACE = 10.0
"""Wall seconds in which a handler that is told to stop has to end, unless its message says more."""


class Constraint(enum.IntFlag):
    """The temporal constraints of a new node (TCA's flags, ``tca.md`` 3.6)."""

    NONE = 0
    SEQ_ACH = 1
    """End(Achieve(previous sibling)) <= Start(Achieve(this))."""
    SEQ_PLANNING = 2
    """End(Plan(previous sibling)) <= Start(Plan(this))."""
    PLAN_FIRST = 4
    """End(Plan(this)) <= Start(Achieve(this))."""
    DELAY_PLANNING = 8
    """Start(Plan(this)) = Start(Achieve(this))."""


class TaskState(enum.StrEnum):
    """The one word for a node that people and scripts see (TCA's reference status)."""

    INACTIVE = "inactive"
    """Held back by a temporal constraint."""
    PENDING = "pending"
    """Free to start, waiting for its handler."""
    ACTIVE = "active"
    """Its handler is running."""
    HANDLED = "handled"
    """Its handler is done, its children are not."""
    PLANNED = "planned"
    """It and all below it are expanded."""
    ACHIEVED = "achieved"
    """It and all below it are carried out."""
    FAILED = "failed"
    """It ended in a failure."""
    KILLED = "killed"
    """It was killed before it ended by itself."""


ENDED = frozenset({TaskState.ACHIEVED, TaskState.FAILED, TaskState.KILLED})
"""The states that never change again."""


class Handling(enum.StrEnum):
    """First phase: the handler."""

    UNHANDLED = "unhandled"
    HANDLING = "handling"
    HANDLED = "handled"


class Planning(enum.StrEnum):
    """Second phase: the expansion of the node and all below it."""

    UNPLANNED = "unplanned"
    PLANNING = "planning"
    PLANNED = "planned"


class Achievement(enum.StrEnum):
    """Third phase: the carrying out of the node and all below it."""

    UNACHIEVED = "unachieved"
    ACHIEVING = "achieving"
    ACHIEVED = "achieved"


class Existence(enum.StrEnum):
    """Fourth phase: being there at all."""

    ALIVE = "alive"
    TERMINATING = "terminating"
    TERMINATED = "terminated"


class TaskStatus(BaseModel):
    """A task node as central publishes it on ``<realm>/task/<sender>/<id>``.

    ``sequence`` grows with each change of the node: of two statuses the higher one is newer.
    Times are those of central's clock, seconds since the epoch. ``waiting_for`` says in words
    what an inactive or pending node waits for. ``traceparent`` is the W3C trace context that it
    was sent from.
    """

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="constants")

    id: str
    name: str
    task_class: TaskClass
    sender: str
    parent: str | None
    state: TaskState
    handling: Handling
    planning: Planning
    achievement: Achievement
    existence: Existence
    handler: str | None = None
    attempt: int = 0
    data: dict[str, Any] = Field(default_factory=dict)
    result: Any = None
    failure: Failure | None = None
    waiting_for: str | None = None
    priority: int = 0
    suspended: bool = False
    retries: int = 0
    created: float
    started: float | None = None
    ended: float | None = None
    sequence: int
    traceparent: str | None = None

    @property
    def is_ended(self) -> bool:
        """Whether this status is final."""
        return self.state in ENDED


class SubmitTask(Query[TaskStatus]):
    """Module to central: make this node. Sent twice it makes one node.

    ``parent`` is the id of the node from whose handler it comes, None for the root.
    ``message_revision`` is that of the sender's type; None where the data have to fit exactly.
    Refused with ``no_handler`` when no module provides the message, unless ``wait_for_handler``
    is above zero: then the node is made, and fails if none comes within so many seconds.

    ``priority`` is that of the whole task for one at the root, below it that of the message among
    those of the same task. ``within`` is a deadline: that many seconds of central's clock after
    the submission the task fails with ``deadline_passed``. ``grace`` is how many wall seconds its
    handler has to end when it is told to stop. ``is_new`` says that the sender has just made the
    id and sends it for the first time, so that the history need not be searched for it.
    """

    wire_name = "tca.submit"

    id: str = Field(pattern=TASK_ID_PATTERN)
    name: str
    task_class: TaskClass
    message_revision: int | None = None
    data: dict[str, Any]
    sender: str
    parent: str | None = None
    constraints: int = Field(default=int(Constraint.SEQ_ACH), ge=0, le=15)
    priority: int = 0
    on_module_lost: ModuleLostPolicy = "fail"
    on_unhandled: UnhandledPolicy = "fail_parent"
    traceparent: str | None = Field(default=None, pattern=TRACEPARENT_PATTERN)
    wait_for_handler: float = Field(default=0.0, ge=0)
    within: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    grace: float = Field(default=KILL_GRACE, gt=0, allow_inf_nan=False)
    is_new: bool = False
    orders: tuple[Order, ...] = ()
    attachments: tuple[Attachment, ...] = ()
    monitor: MonitorSpec | None = None


class KillTask(Query[TaskStatus]):
    """Anybody to central: kill the node and all below it, or only what is below it."""

    wire_name = "tca.kill"

    id: str = Field(pattern=TASK_ID_PATTERN)
    reason: str = "killed by request"
    only_below: bool = False


class FindTask(Query[TaskStatus]):
    """Anybody to central: the status of one task, also of one that ended long ago.

    ``awaited_by`` is the task whose handler waits for its end, ``holding`` the holds on resources
    that are kept meanwhile; asked again every few seconds, it lets central see who waits for whom.
    """

    wire_name = "tca.task"

    id: str = Field(pattern=TASK_ID_PATTERN)
    awaited_by: str | None = None
    holding: tuple[str, ...] = ()


class ListTasks(Query[list[TaskStatus]]):
    """Anybody to central: the nodes that are alive, or those at and below ``id``.

    With ``ended`` set the last ended top-level tasks are there too. Of what ended below a task that
    is alive the latest are shown with it: for an ``id`` always, for all with ``ended``.
    """

    wire_name = "tca.tasks"

    id: str | None = None
    ended: bool = False


class LogEntry(BaseModel):
    """One line of the task history, from the journal.

    ``event`` is a word for scripts, ``text`` a sentence for people, ``statements`` the same in
    the terms of TCA's log. ``node`` numbers the node in that log, ``root`` is the top-level task
    above it; ``data`` come with the line that says that it was submitted.
    """

    model_config = ConfigDict(frozen=True)

    number: int
    time: float
    task: str
    name: str
    event: str
    text: str
    root: str = ""
    node: int | None = None
    task_class: str = ""
    data: dict[str, Any] | None = None
    statements: tuple[Statement, ...] = ()


class ReadLog(Query[list[LogEntry]]):
    """Anybody to central: the history after entry number ``after``, at most ``most`` lines.

    ``after`` below zero counts from the end: the last so many lines. Only those of ``task`` and
    all below it, of the messages named in ``messages``, and of none in ``ignore``.
    """

    wire_name = "tca.log"

    after: int = 0
    most: int = Field(default=1000, ge=1, le=10_000)
    task: str | None = None
    messages: tuple[str, ...] = Field(default=(), max_length=1000)
    ignore: tuple[str, ...] = Field(default=(), max_length=1000)


class Taken(BaseModel):
    """A module's word that it works on a task, or has the outcome ready."""

    model_config = ConfigDict(frozen=True)

    id: str
    attempt: int


class HandleTask(Query[Taken]):
    """Central to a module: handle this node. Sent twice for one attempt it is handled once."""

    wire_name = "tca.handle"

    id: str = Field(pattern=TASK_ID_PATTERN)
    attempt: int = Field(ge=1)
    name: str
    task_class: TaskClass
    message_revision: int | None = None
    data: dict[str, Any]
    sender: str
    parent: str | None = None
    grace: float = KILL_GRACE
    monitor: MonitorSpec | None = None
    retries: int = 0


class CancelTask(Query[Taken]):
    """Central to a module: stop handling this node; its outcome is still to be reported."""

    wire_name = "tca.cancel"

    id: str = Field(pattern=TASK_ID_PATTERN)
    attempt: int = Field(ge=1)
    reason: str


class Outcome(enum.StrEnum):
    """How a handler ended."""

    SUCCESS = "success"
    FAILURE = "failure"
    KILLED = "killed"


class ReportOutcome(Query[Taken]):
    """The handling module to central: how the handler ended.

    ``seen_failures`` are the children whose failures the handler received itself; they do not
    fail the node. ``resolution`` is what an exception handler decided. Repeated until central has
    acknowledged it, which it does after journaling.
    """

    wire_name = "tca.report"

    id: str = Field(pattern=TASK_ID_PATTERN)
    attempt: int = Field(ge=1)
    outcome: Outcome
    result: Any = None
    failure: Failure | None = None
    seen_failures: tuple[str, ...] = ()
    resolution: Resolution | None = None


class ProvidedMessage(BaseModel):
    """A message that a module handles, with the JSON schemas of it and of its answer.

    ``capacity`` is how many of it the module handles at once, None for as many as come; the rest
    waits at central, or in the line of the pool if it is a query. Those in one ``resource`` share
    its capacity. ``pending`` is how many of it may wait. ``accepts`` are older revisions that it
    understands, ``traits`` how a goal or command is carried out.
    """

    model_config = ConfigDict(frozen=True)

    name: str
    message_class: str
    revision: int
    accepts: list[int] = []
    capacity: int | None = 1
    resource: str | None = None
    pending: int | None = None
    summary: str
    message_schema: dict[str, Any]
    reply_schema: dict[str, Any] | None
    traits: TaskTraits | None = None


class ProvidedResource(BaseModel):
    """What several handlers of a module share; the one of the module's name, all of them."""

    model_config = ConfigDict(frozen=True)

    name: str
    capacity: int = 1
    pending: int | None = None


class ModuleCard(BaseModel):
    """What a module says of itself: who it is, what it provides, has lost and is working on."""

    model_config = ConfigDict(frozen=True)

    name: str
    incarnation: str
    pid: int
    host: str
    version: str
    started: float
    provides: list[ProvidedMessage]
    resources: list[ProvidedResource] = []
    dropped: dict[str, int]
    invalid: int
    handling: list[Taken]


class Describe(Query[ModuleCard]):
    """Anybody to a module: introduce yourself."""

    wire_name = "tca.describe"
