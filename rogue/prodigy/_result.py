"""How a search ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from rogue.prodigy._terms import Literal

if TYPE_CHECKING:
    from rogue.prodigy._events import StepView


class Status(StrEnum):
    """The four ways in which a search ends."""

    SOLVED = "solved"
    """A plan was found (and executed, if execution was asked for)."""
    UNSOLVABLE = "unsolvable"
    """There is no plan: proved, not presumed."""
    LIMIT = "limit"
    """Gave up: at a bound, or out of alternatives without a proof; the reason says which."""
    STOPPED = "stopped"
    """The caller, or a handler, stopped it."""


class LimitKind(StrEnum):
    """What a search can run out of."""

    NODES = "nodes"
    """Nodes made: ``SearchOptions.max_nodes``."""
    SECONDS = "seconds"
    """Seconds spent: ``SearchOptions.time_limit``."""
    DEPTH = "depth"
    """Every branch left lies deeper than ``SearchOptions.depth_bound``."""
    HELD = "held"
    """Nodes held at once: ``SearchOptions.max_held``."""
    BINDINGS = "bindings"
    """Values tried in one step: ``SearchOptions.max_bindings``."""
    PROOF_STATES = "proof-states"
    """No alternatives are left, and ``SearchOptions.proof_states`` did not do for a proof."""


@dataclass(frozen=True, slots=True)
class Limit:
    """The bound at which a search gave up, and its value."""

    kind: LimitKind
    value: float

    def __str__(self) -> str:
        shown = f"{self.value:g}"
        match self.kind:
            case LimitKind.SECONDS:
                return f"gave up after {shown} s"
            case LimitKind.DEPTH:
                return f"gave up: no alternatives are left above the depth bound ({shown})"
            case LimitKind.HELD:
                return f"gave up with {int(self.value)} nodes held"
            case LimitKind.BINDINGS:
                return f"gave up: more than {int(self.value)} values to try in one step"
            case LimitKind.PROOF_STATES:
                return "gave up: no alternatives are left"
        return f"gave up after {int(self.value)} nodes"


@dataclass(frozen=True, slots=True)
class Stop:
    """Who stopped a search, and why; a handler returns one to end the search."""

    why: str
    by: str = "the caller"


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The outcome of a search.

    Attributes:
        status: One of the four.
        plan: The applied operators in order; for a search that executes, the executed ones. Of
            several solutions the last.
        nodes: Nodes made.
        seconds: Time spent searching on the search's clock; what the caller did between events,
            executing among it, is not counted.
        trace: The printed lines.
        reason: In a sentence, why it ended so.
        hopeless: For an unsolvable problem, goals that cannot be reached each by itself; empty
            where only their combination is at fault.
        limit: The bound at which it gave up; also set where some solutions were found before.
        stop: Who stopped it and why.
        solutions: How many solutions were found.
    """

    status: Status
    plan: tuple[StepView, ...]
    nodes: int
    seconds: float
    trace: tuple[str, ...]
    reason: str = ""
    hopeless: tuple[Literal, ...] = ()
    limit: Limit | None = None
    stop: Stop | None = None
    solutions: int = 0
