"""What a line of TCA's log can say: one model for each shape of line that its viewers read.

The shapes are those of the log grammar of *comview* (Simmons, CMU); `tca_bus._log_grammar`
writes them.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

MessageWord = Literal[
    "Query", "Goal", "Command", "Inform", "Broadcast", "Exception", "IMonitor", "PMonitor", "ByPass"
]
StatusWord = Literal["Sent", "Pending", "Inactive", "Completed"]
Situation = Literal[
    "when it completes",
    "when submessages complete",
    "when all references to it are released",
]
IntervalWord = Literal["Handling", "Planning", "Achievement"]
ConstraintWord = Literal[
    "SEQUENTIAL ACHIEVEMENT", "SEQUENTIAL PLANNING", "DELAY PLANNING", "PLAN FIRST"
]


class _Said(BaseModel):
    model_config = ConfigDict(frozen=True)


class NodeRef(_Said):
    """A node by its message's name and its number in the log; central may not know the number."""

    name: str
    number: int | None = None


class TimePoint(_Said):
    """The start or the end of an interval of a node."""

    end: Literal["Start", "End"]
    interval: IntervalWord
    node: NodeRef


class MessagePassed(_Said):
    """A message went from a source to a destination, or only its status changed.

    ``source`` is a module, ``ON HOLD`` or ``Resource NAME``; without it and ``destination`` the
    line gives the status alone. ``parent`` is the number of the parent node.
    """

    says: Literal["passed"] = "passed"
    word: MessageWord
    node: NodeRef
    status: StatusWord
    source: str | None = None
    destination: str | None = None
    parent: int | None = None


class Answered(_Said):
    """A handler answered: a success, or a failure of ``module``."""

    says: Literal["answered"] = "answered"
    word: Literal["Success", "Done", "Failure"]
    node: NodeRef
    module: str = ""
    parent: int | None = None


class Replied(_Said):
    """The reply to a query went from one module to another."""

    says: Literal["replied"] = "replied"
    node: NodeRef
    source: str
    destination: str
    parent: int | None = None


class RetryAsked(_Said):
    """A node is handled again."""

    says: Literal["retried"] = "retried"
    node: NodeRef


class DemonFired(_Said):
    """A demon monitor was fired by a module."""

    says: Literal["fired"] = "fired"
    number: int | None
    source: str
    destination: str
    status: StatusWord
    parent: int | None = None


class NodeKilled(_Said):
    """A node was killed, or its message was dropped since too many waited (``by_limit``)."""

    says: Literal["killed"] = "killed"
    node: NodeRef
    by_limit: bool = False


class KillAwaited(_Said):
    """A node will be killed."""

    says: Literal["will kill"] = "will kill"
    node: NodeRef
    situation: Situation


class PointsOrdered(_Said):
    """A constraint between two points."""

    says: Literal["asserted"] = "asserted"
    first: TimePoint
    relation: Literal["<", "<=", "=", ">=", ">"]
    second: TimePoint


class ConstraintAdded(_Said):
    """One of TCA's four constraints; the sequential ones stand between two nodes.

    Raises:
        ValidationError: A sequential one has no ``previous`` node, or another has one.
    """

    says: Literal["added"] = "added"
    constraint: ConstraintWord
    node: NodeRef
    previous: NodeRef | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.constraint.startswith("SEQUENTIAL") != (self.previous is not None):
            raise ValueError(f"previous: {self.constraint} got {self.previous}")
        return self


class Remark(_Said):
    """What TCA's grammar has no words for; its readers skip it."""

    says: Literal["remark"] = "remark"
    text: str


Statement = Annotated[
    MessagePassed
    | Answered
    | Replied
    | RetryAsked
    | DemonFired
    | NodeKilled
    | KillAwaited
    | PointsOrdered
    | ConstraintAdded
    | Remark,
    Field(discriminator="says"),
]
"""What one line says."""
