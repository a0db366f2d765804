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
    """The caller stopped it."""


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The outcome of a search.

    Attributes:
        status: One of the four.
        plan: The applied operators in order; for a search that executes, the executed ones.
        nodes: Nodes made.
        seconds: Time spent searching on the search's clock; what the caller did between events,
            executing among it, is not counted.
        trace: The printed lines.
        reason: In a sentence, why it ended so.
        hopeless: For an unsolvable problem, goals that cannot be reached each by itself; empty
            where only their combination is at fault.
    """

    status: Status
    plan: tuple[StepView, ...]
    nodes: int
    seconds: float
    trace: tuple[str, ...]
    reason: str = ""
    hopeless: tuple[Literal, ...] = ()
