"""What the agent must not forget, in one SQLite file."""

from __future__ import annotations

from rogue.memory._database import Database
from rogue.memory._facts import Facts
from rogue.memory._holds import Hold
from rogue.memory._likeness import Difference, first_difference
from rogue.memory._steps import PastStep, Step, TimedStep
from rogue.memory._store import FILE_NAME, Store

__all__ = [
    "FILE_NAME",
    "Database",
    "Difference",
    "Facts",
    "Hold",
    "PastStep",
    "Step",
    "Store",
    "TimedStep",
    "first_difference",
]
