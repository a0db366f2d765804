"""One node of the task tree: its phases, the points it waits for, its place in the tree."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from tca_bus._failure import Failure
from tca_bus._protocol import (
    Achievement,
    Existence,
    Handling,
    Planning,
    SubmitTask,
    TaskState,
    TaskStatus,
)
from tca_bus.tasktree._points import Point, PointOf


@dataclass(slots=True, eq=False)
class Node:
    """A goal or a command.

    ``open`` holds for each point of this node the points that must pass before it, ``waiters``
    the points of other nodes that wait for one of this node's. ``fate`` is what the node will
    end as when all below it has ended; it is set from the moment the node terminates.
    """

    task: SubmitTask
    created: float
    sequence: int = 0
    attempt: int = 0
    handler: str | None = None
    incarnation: str | None = None
    handling: Handling = Handling.UNHANDLED
    taken: bool = False
    restarting: bool = False
    passed: set[Point] = field(default_factory=set)
    open: dict[Point, dict[PointOf, None]] = field(default_factory=dict)
    waiters: dict[Point, list[PointOf]] = field(default_factory=dict)
    existence: Existence = Existence.ALIVE
    fate: TaskState | None = None
    result: Any = None
    failure: Failure | None = None
    started: float | None = None
    ended: float | None = None
    children: list[str] = field(default_factory=list)
    alive: dict[str, None] = field(default_factory=dict)
    failed: dict[str, Failure] = field(default_factory=dict)

    @property
    def id(self) -> str:
        """The id of the node."""
        return self.task.id

    @property
    def is_goal(self) -> bool:
        """Whether it is a goal, else a command."""
        return self.task.task_class == "goal"

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
        """Whether its handler may be chosen now."""
        free = self.handling is Handling.UNHANDLED and not self.open[Point.START_HANDLING]
        return self.is_alive and free and not self.restarting

    def ahead(self) -> tuple[Point, ...]:
        """The ends of its intervals that may still pass."""
        ends = (Point.END_PLANNING, Point.END_ACHIEVING)
        return () if self.has_ended else tuple(end for end in ends if end not in self.passed)

    def waits_for(self, other: str, point: Point) -> bool:
        """Whether any of its points waits for that of another node."""
        return any((other, point) in points for points in self.open.values())

    def state(self) -> TaskState:
        """The one word for the node."""
        if self.has_ended and self.fate is not None:
            return self.fate
        if self.handling is Handling.HANDLING:
            return TaskState.ACTIVE if self.taken else TaskState.PENDING
        if self.handling is Handling.HANDLED:
            planned = self.is_goal and Point.END_PLANNING in self.passed
            return TaskState.PLANNED if planned else TaskState.HANDLED
        return TaskState.INACTIVE if self.open[Point.START_HANDLING] else TaskState.PENDING

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

    def status(self, waiting_for: str | None) -> TaskStatus:
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
            priority=self.task.priority,
            created=self.created,
            started=self.started,
            ended=self.ended,
            sequence=self.sequence,
        )
