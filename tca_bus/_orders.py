"""Constraints between points in time: what of which task comes before what of another.

Each task has three intervals, each with a start and an end (``tcaHandlingOf``, ``tcaStartOf``).
A constraint is written as a comparison and sent with `Module.constrain` or along with a task::

    drive.achieving.end <= ask.handling.start
    drive.achieving.end + 5.0 <= ask.achieving.start     # not within 5 s after
    ask.achieving.start >= 1_700_000_000.0               # not before that time
    look.achieving.start.together_with(drive.achieving.start)

Source: Simmons, *Structured control for autonomous robots* (1994); ``tcaTplConstrain``.
"""

from __future__ import annotations

import enum
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

TASK_ID_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._:+-]{0,119}$"
"""A task id is one chunk of a key expression, made by the sender."""


class Point(enum.StrEnum):
    """Start and end of the intervals of a task."""

    START_HANDLING = "start of handling"
    END_HANDLING = "end of handling"
    START_PLANNING = "start of planning"
    END_PLANNING = "end of planning"
    START_ACHIEVING = "start of achievement"
    END_ACHIEVING = "end of achievement"
    START_RECOVERY = "start of recovery"
    """A failure is about to be offered to exception handlers; not to be named in constraints."""
    EXPIRY = "expiry"
    """A monitor ends; not to be named in constraints, see `MonitorOptions.until`."""


NAMEABLE = frozenset(set(Point) - {Point.START_RECOVERY, Point.EXPIRY})
"""The points that constraints may name."""

Relation = Literal["<", "<=", "="]


class PointRef(BaseModel):
    """A point of the task with this id."""

    model_config = ConfigDict(frozen=True)

    task: str = Field(pattern=TASK_ID_PATTERN)
    point: Point

    def __str__(self) -> str:
        return f"{self.point.value} of {self.task}"


class Order(BaseModel):
    """One constraint: ``first`` + ``delay`` seconds <= ``then``.

    Without ``first`` the point ``then`` does not pass before the time ``at`` of central's clock,
    in seconds since the epoch. ``=`` makes the two points pass together. Points pass one after
    the other, so ``<`` differs from ``<=`` only in that it contradicts ``=``.
    """

    model_config = ConfigDict(frozen=True)

    first: PointRef | None = None
    relation: Relation = "<="
    then: PointRef
    delay: float = Field(default=0.0, ge=0.0, allow_inf_nan=False)
    at: float | None = Field(default=None, allow_inf_nan=False)

    @model_validator(mode="after")
    def _check(self) -> Order:
        if (self.first is None) == (self.at is None):
            raise ValueError("first: expected either a point or, in 'at', a time")
        if self.relation == "=" and (self.first is None or self.delay):
            raise ValueError("relation: '=' holds between two points and takes no delay")
        for ref in (self.first, self.then):
            if ref is not None and ref.point not in NAMEABLE:
                raise ValueError(f"point: {ref.point.value!r} cannot be in a constraint")
        if self.first == self.then:
            raise ValueError(f"first: a point cannot be before itself ({self.then})")
        return self

    def __str__(self) -> str:
        first = f"time {self.at:g}" if self.first is None else str(self.first)
        delay = f" + {self.delay:g} s" if self.delay else ""
        return f"{first}{delay} {self.relation} {self.then}"


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """A point of a task, perhaps some seconds later; comparing two makes an `Order`."""

    ref: PointRef
    delay: float = 0.0

    def __add__(self, seconds: float) -> Moment:
        return Moment(self.ref, self.delay + seconds)

    def __le__(self, other: Moment) -> Order:
        return _order(self, other, "<=")

    def __lt__(self, other: Moment) -> Order:
        return _order(self, other, "<")

    def __ge__(self, other: Moment | float) -> Order:
        if isinstance(other, Moment):
            return _order(other, self, "<=")
        return Order(then=self.ref, at=float(other))

    def __gt__(self, other: Moment) -> Order:
        return _order(other, self, "<")

    def together_with(self, other: Moment) -> Order:
        """The two points pass together."""
        return _order(self, other, "=")


def _order(first: Moment, then: Moment, relation: Relation) -> Order:
    """Make the constraint; a delay on the later point has no meaning.

    Raises:
        ValueError: The later point has a delay, or a delay is no number.
    """
    if then.delay or not math.isfinite(first.delay):
        raise ValueError("a delay stands on the earlier point: first + seconds <= then")
    return Order(first=first.ref, relation=relation, then=then.ref, delay=first.delay)


@dataclass(frozen=True, slots=True)
class Interval:
    """Handling, planning or achievement of one task."""

    start: Moment
    end: Moment


class HasPoints(ABC):
    """What has the id of a task, and so its points."""

    @abstractmethod
    def id_of(self) -> str:
        """The id of the task."""

    @property
    def handling(self) -> Interval:
        """From the delivery to the handler until it has answered."""
        return self._interval(Point.START_HANDLING, Point.END_HANDLING)

    @property
    def planning(self) -> Interval:
        """Until the task and all below it are expanded."""
        return self._interval(Point.START_PLANNING, Point.END_PLANNING)

    @property
    def achieving(self) -> Interval:
        """Until the task and all below it are carried out."""
        return self._interval(Point.START_ACHIEVING, Point.END_ACHIEVING)

    def _interval(self, start: Point, end: Point) -> Interval:
        return Interval(
            Moment(PointRef(task=self.id_of(), point=start)),
            Moment(PointRef(task=self.id_of(), point=end)),
        )


@dataclass(frozen=True, slots=True)
class TaskRef(HasPoints):
    """A task by its id, sent or only prepared."""

    id: str

    def id_of(self) -> str:
        """The id of the task."""
        return self.id
