"""Scripts that play in a whole office."""

from __future__ import annotations

from rogue.scenarios._papers import (
    ARRIVED,
    EPOCH,
    SCENARIOS,
    SENDING,
    VERIFYING,
    Arrival,
    Errand,
    Measurements,
    Observer,
    Poster,
    Scenario,
)

__all__ = [
    "ARRIVED",
    "EPOCH",
    "SCENARIOS",
    "SENDING",
    "VERIFYING",
    "Arrival",
    "Errand",
    "Measurements",
    "Observer",
    "Poster",
    "Scenario",
]
