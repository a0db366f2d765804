"""The switches of a search."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from rogue.prodigy._events import StepView

StepCost = Callable[[StepView], float]


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


class Solutions(StrEnum):
    """How many solutions are searched for."""

    ONE = "one"
    """The first."""
    ALL = "all"
    """Every one that the search comes to, the same plan also twice if in two ways."""
    DIFFERENT = "different"
    """Every plan once."""
    SHORTER = "shorter"
    """Only plans of fewer steps than all before."""
    CHEAPER = "cheaper"
    """Only plans that cost less than all before, by ``SearchOptions.step_cost``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """Switches and limits of one search.

    Attributes:
        mode: SABA (ROGUE) or SAVTA (PRODIGY's default).
        execute: Ask the caller to execute each operator when its node is visited.
        poll: Where requests that arrived during an execution enter.
        level: What is traced: 0 nothing, 1 the plan, 2 nodes, 3 nodes and rules.
        solutions: Which solutions are searched for; one only where plans are executed.
        step_cost: What a step costs, never less than 0; 1 for each where it is None.
        min_conspiracy_number: Try the bindings with the fewest false preconditions first.
        use_abs_level: Try goals of a higher abstraction level first; the levels come from the
            domain by themselves.
        excise_loops: Close what cannot succeed because something below failed whatever the order
            of steps.
        revisit: Let a step lead to a state that was left by an executed step. What is executed
            takes time, in which the rules may have learnt why to go back; without it that is a
            state loop. A domain whose rules wander then ends at a limit.
        protection: Where nothing else is left, keep a conditional effect from undoing what is
            needed by making its condition false first.
        depth_bound: Deepest node that may be expanded; None for no bound.
        max_nodes: Most nodes that may be made; None for no bound.
        max_held: Most nodes, trace lines and decisions held in memory. What was executed long
            ago is let go first; a search that needs more than that gives up.
        max_bindings: Most values tried in one step, as in binding one operator for one goal, with
            all values and literals of the bindings found.
        time_limit: Seconds on ``clock``; None for no bound.
        proof_states: Most states looked at to prove a problem unsolvable.
        clock: Monotonic seconds.
    """

    mode: Mode = Mode.SABA
    execute: bool = False
    poll: PollPoint = PollPoint.END_OF_CYCLE
    level: int = 2
    solutions: Solutions = Solutions.ONE
    step_cost: StepCost | None = None
    min_conspiracy_number: bool = True
    use_abs_level: bool = True
    excise_loops: bool = True
    revisit: bool = False
    protection: bool = False
    depth_bound: int | None = 200
    max_nodes: int | None = 20_000
    max_held: int = 200_000
    max_bindings: int = 500_000
    time_limit: float | None = 60.0
    proof_states: int = 20_000
    clock: Callable[[], float] = time.monotonic
