"""A problem as it is read from files, in whichever language."""

from __future__ import annotations

from dataclasses import dataclass, field

from rogue.prodigy._costs import Costs
from rogue.prodigy._problem import Problem


@dataclass(frozen=True, slots=True)
class Task:
    """A problem, and what its plans cost.

    Attributes:
        problem: What PRODIGY plans.
        costs: What each step costs; 1 where the text says nothing of costs.
        minimize: Whether the text asks for a plan that costs little.
    """

    problem: Problem
    costs: Costs = field(default_factory=Costs)
    minimize: bool = False
