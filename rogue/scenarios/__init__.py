"""Scripts that play in a whole office: the papers' scenarios, and a day with many users."""

from __future__ import annotations

from rogue.scenarios._day_plan import DayPlan, Kind, Post, Staff, make_day
from rogue.scenarios._day_run import DayRun
from rogue.scenarios._day_verdict import (
    DayRecord,
    Handover,
    Verified,
    counts,
    differences,
    faults,
    verification,
)
from rogue.scenarios._measurements import Measurements, Observer
from rogue.scenarios._papers import EPOCH, SCENARIOS, SENDING, VERIFYING, Scenario
from rogue.scenarios._prompter import Prompter
from rogue.scenarios._stage import Stage, stage

__all__ = [
    "EPOCH",
    "SCENARIOS",
    "SENDING",
    "VERIFYING",
    "DayPlan",
    "DayRecord",
    "DayRun",
    "Handover",
    "Kind",
    "Measurements",
    "Observer",
    "Post",
    "Prompter",
    "Scenario",
    "Staff",
    "Stage",
    "Verified",
    "counts",
    "differences",
    "faults",
    "make_day",
    "stage",
    "verification",
]
