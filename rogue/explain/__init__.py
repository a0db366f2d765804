"""What the planner thinks, made visible and told in sentences; pure, without a bus."""

from __future__ import annotations

from rogue.explain._chronicle import Chronicle, Concern
from rogue.explain._decision import ROUTINE, Decision, DecisionKind, Rival
from rogue.explain._rules import RULES, because
from rogue.explain._sentences import in_words, sentence
from rogue.explain._story import Entry, Record, story, told
from rogue.explain._svg import draw_svg

__all__ = [
    "ROUTINE",
    "RULES",
    "Chronicle",
    "Concern",
    "Decision",
    "DecisionKind",
    "Entry",
    "Record",
    "Rival",
    "because",
    "draw_svg",
    "in_words",
    "sentence",
    "story",
    "told",
]
