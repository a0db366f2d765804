"""One node of the task tree: its phases, the points it waits for, its place in the tree."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from tca_bus._attachments import Catch, CleanUp, Resolution, Tap
from tca_bus._failure import Failure
from tca_bus._orders import Point
from tca_bus._protocol import (
    Achievement,
    Existence,
    Handling,
    Planning,
    SubmitTask,
    TaskState,
    TaskStatus,
)
from tca_bus.tasktree._events import Origin, Role

PointOf = tuple[str, Point]
"""A point of the node with this id."""

DEADLINE = "deadline"
"""The key of the alarm for a node's deadline."""


class Source(NamedTuple):
    """What a point waits for: a point of a node, perhaps ``delay`` seconds after it.

    Without a node it is the alarm ``alarm`` of the waiting node itself.
    """

    id: str
    point: Point | None
    delay: float = 0.0
    alarm: str = ""


@dataclass(slots=True, eq=False)
class Recovery:
    """What is being done about the node's failure: by which handler, which had it before.

    ``decision`` is what the handler decided; it takes effect when the handler's node has ended.
    """

    tried: set[str] = field(default_factory=set)
    handler: str = ""
    decision: Resolution | None = None


@dataclass(slots=True, eq=False)
class Watch:
    """The counts of a monitor: satisfied tests, in all and told by this attempt, and firings."""

    satisfied: int = 0
    told: int = 0
    fired: int = 0
    expired: bool = False


@dataclass(slots=True, eq=False)
class Node:
    """A goal, a command, a monitor or an exception handler at work.

    ``open`` holds for each point of this node what must pass before it, ``waiters`` the points of
    other nodes that wait for one of this node's. ``twins`` are points that pass together with
    one. ``fate`` is what the node will end as when all below it has ended; it is set from the
    moment the node terminates. ``answered`` means that its handler has succeeded, ``failing``
    that it has a failure that nobody has taken yet, ``doomed`` why its handler is being stopped,
    ``rites`` that its clean-ups were sent.
    """

    task: SubmitTask
    created: float
    root: str
    origin: Origin = field(default_factory=Origin)
    prepared: bool = False
    sequence: int = 0
    attempt: int = 0
    retries: int = 0
    priority: int = 0
    handler: str | None = None
    incarnation: str | None = None
    handling: Handling = Handling.UNHANDLED
    taken: bool = False
    restarting: bool = False
    only: str | None = None
    suspended: bool = False
    answered: bool = False
    failing: bool = False
    doomed: Failure | None = None
    passed: dict[Point, float] = field(default_factory=dict)
    open: dict[Point, dict[Source, None]] = field(default_factory=dict)
    waiters: dict[Point, list[tuple[PointOf, float]]] = field(default_factory=dict)
    twins: dict[Point, list[PointOf]] = field(default_factory=dict)
    alarms: dict[str, float] = field(default_factory=dict)
    existence: Existence = Existence.ALIVE
    fate: TaskState | None = None
    result: Any = None
    failure: Failure | None = None
    started: float | None = None
    ended: float | None = None
    children: dict[str, None] = field(default_factory=dict)
    alive: dict[str, None] = field(default_factory=dict)
    monitors: dict[str, None] = field(default_factory=dict)
    last_step: str | None = None
    spawned: int = 0
    failed: dict[str, Failure] = field(default_factory=dict)
    taps: dict[str, Tap] = field(default_factory=dict)
    gated: set[str] = field(default_factory=set)
    catches: dict[str, Catch] = field(default_factory=dict)
    clean_ups: dict[str, CleanUp] = field(default_factory=dict)
    recovery: Recovery | None = None
    watch: Watch | None = None
    rites: bool = False

    @property
    def id(self) -> str:
        """The id of the node."""
        return self.task.id

    @property
    def role(self) -> Role:
        """Why it is where it is in the tree."""
        return self.origin.role

    @property
    def is_goal(self) -> bool:
        """Whether it is handled when planning starts: a goal, or an exception handler."""
        return self.task.task_class in {"goal", "exception"}

    @property
    def is_interval_monitor(self) -> bool:
        """Whether it lasts until it expires, and so holds its parent no longer than that."""
        return self.task.monitor is not None and self.task.monitor.kind != "point"

    @property
    def is_alive(self) -> bool:
        """Whether it neither has ended nor is about to."""
        return self.existence is Existence.ALIVE

    @property
    def has_ended(self) -> bool:
        """Whether it never changes again."""
        return self.existence is Existence.TERMINATED

    @property
    def is_handling(self) -> bool:
        """Whether a module has it, or was chosen for it."""
        return self.handling is Handling.HANDLING

    @property
    def is_ready(self) -> bool:
        """Whether its handler may be chosen now, unless it is suspended."""
        free = self.handling is Handling.UNHANDLED and not self.open[Point.START_HANDLING]
        blocked = self.restarting or self.failing or self.prepared
        return self.is_alive and free and not blocked

    def ahead(self) -> tuple[Point, ...]:
        """The ends of its intervals that may still pass."""
        ends = (Point.END_PLANNING, Point.END_ACHIEVING)
        return () if self.has_ended else tuple(end for end in ends if end not in self.passed)

    def waits_for(self, source: Source) -> bool:
        """Whether any of its points waits for that."""
        return any(source in sources for sources in self.open.values())

    def state(self) -> TaskState:
        """The one word for the node."""
        if self.has_ended and self.fate is not None:
            return self.fate
        if self.handling is Handling.HANDLING:
            return TaskState.ACTIVE if self.taken else TaskState.PENDING
        if self.handling is Handling.HANDLED:
            planned = self.is_goal and Point.END_PLANNING in self.passed
            return TaskState.PLANNED if planned else TaskState.HANDLED
        held = self.open[Point.START_HANDLING] or self.prepared
        return TaskState.INACTIVE if held else TaskState.PENDING

    def planning(self) -> Planning:
        """The second phase."""
        if Point.END_PLANNING in self.passed:
            return Planning.PLANNED
        started = Point.START_PLANNING in self.passed
        return Planning.PLANNING if started else Planning.UNPLANNED

    def achievement(self) -> Achievement:
        """The third phase."""
        if Point.END_ACHIEVING in self.passed:
            return Achievement.ACHIEVED
        started = Point.START_ACHIEVING in self.passed
        return Achievement.ACHIEVING if started else Achievement.UNACHIEVED

    def status(self, waiting_for: str | None, *, suspended: bool) -> TaskStatus:
        """The node as others see it."""
        return TaskStatus(
            id=self.id,
            name=self.task.name,
            task_class=self.task.task_class,
            sender=self.task.sender,
            parent=self.task.parent,
            state=self.state(),
            handling=self.handling,
            planning=self.planning(),
            achievement=self.achievement(),
            existence=self.existence,
            handler=self.handler,
            attempt=self.attempt,
            data=self.task.data,
            result=self.result,
            failure=self.failure,
            waiting_for=waiting_for,
            priority=self.priority,
            suspended=suspended,
            retries=self.retries,
            created=self.created,
            started=self.started,
            ended=self.ended,
            sequence=self.sequence,
            traceparent=self.task.traceparent,
        )
