"""The switches of a search."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum


class Mode(StrEnum):
    """When to back-chain and when to apply."""

    SABA = "saba"
    """Sub-goal always before applying: apply only when no goal is pending, any ready operator."""
    SAVTA = "savta"
    """Sub-goal after visiting the tail: only the newest operator, as soon as it is ready."""


class PollPoint(StrEnum):
    """When the caller is asked for what has happened meanwhile."""

    END_OF_CYCLE = "end-of-cycle"
    """After a node was expanded and before the next is visited (PRODIGY4.0, ROGUE 1996)."""
    BEFORE_EXPANSION = "before-expansion"
    """After an action was executed and before its node is expanded (ROGUE 1998).

    The poll at the end of each cycle happens in this mode too.
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """Switches and limits of one search.

    Attributes:
        mode: SABA (ROGUE) or SAVTA (PRODIGY's default).
        execute: Ask the caller to execute each operator when its node is visited.
        poll: Where requests that arrived during an execution enter.
        level: What is traced: 0 nothing, 1 the plan, 2 nodes, 3 nodes and rules.
        depth_bound: Deepest node that may be expanded; None for no bound.
        max_nodes: Most nodes that may be made; None for no bound.
        time_limit: Seconds on ``clock``; None for no bound.
        proof_states: Most states looked at to prove a problem unsolvable.
        clock: Monotonic seconds.
    """

    mode: Mode = Mode.SABA
    execute: bool = False
    poll: PollPoint = PollPoint.END_OF_CYCLE
    level: int = 2
    depth_bound: int | None = 200
    max_nodes: int | None = 20_000
    time_limit: float | None = 60.0
    proof_states: int = 20_000
    clock: Callable[[], float] = time.monotonic
