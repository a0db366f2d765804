"""What is recorded of a decision, so that a request's user can be told why."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class DecisionKind(StrEnum):
    """What was decided."""

    PLANNED = "planned"
    """The planner took the request up."""
    GOAL = "goal"
    """The planner chose what is needed for it next."""
    OPERATOR = "operator"
    """The planner chose how a goal is to be reached."""
    BINDINGS = "bindings"
    """The planner chose with what and where."""
    STEP = "step"
    """The robot was told to do this next."""
    WAITS = "waits"
    """A step for another request was done first."""
    OVERTAKEN = "overtaken"
    """The same, and the other request came later and is more important."""
    MERGED = "merged"
    """It shares a step with another request."""
    DEAD_END = "dead end"
    """The planner found that something cannot be done in one way."""
    POSTPONED = "postponed"
    """It waits until a time, for what stood in its way."""
    RESUMED = "resumed"
    """What stood in its way is gone."""
    MOVED = "moved"
    """It goes on in another room."""


ROUTINE = frozenset(
    {
        DecisionKind.GOAL,
        DecisionKind.OPERATOR,
        DecisionKind.BINDINGS,
        DecisionKind.DEAD_END,
    }
)
"""Decisions that tell little; the first to be forgotten where there are many."""


@dataclass(frozen=True, slots=True)
class Rival:
    """A request for whose sake another waits, or that shares something with it."""

    id: str
    rank: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """A decision as it concerns some requests.

    Attributes:
        time: Seconds since the epoch, on the robot's clock.
        kind: What was decided.
        requests: Ids of those whom it concerns.
        rule: Name of the rule that decided, or of PRODIGY's default.
        chosen: What was chosen, as PRODIGY writes it.
        over: What else could have been chosen.
        rivals: The other requests that come first, or that share the step.
        reason: Why it failed, or was put off; where it goes on.
        until: When it is tried again, in seconds since the epoch.
    """

    time: float
    kind: DecisionKind
    requests: tuple[str, ...]
    rule: str = ""
    chosen: str = ""
    over: tuple[str, ...] = ()
    rivals: tuple[Rival, ...] = ()
    reason: str = ""
    until: float | None = None

    @property
    def is_routine(self) -> bool:
        """Whether it is the first to be forgotten."""
        return self.kind in ROUTINE
