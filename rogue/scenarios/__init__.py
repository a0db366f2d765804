"""Scripts that play in a whole office: the papers' scenarios."""

from __future__ import annotations

from rogue.scenarios._measurements import Measurements, Observer
from rogue.scenarios._papers import EPOCH, SCENARIOS, SENDING, VERIFYING, Scenario
from rogue.scenarios._prompter import Prompter
from rogue.scenarios._stage import Stage, stage

__all__ = [
    "EPOCH",
    "SCENARIOS",
    "SENDING",
    "VERIFYING",
    "Measurements",
    "Observer",
    "Prompter",
    "Scenario",
    "Stage",
    "stage",
]
