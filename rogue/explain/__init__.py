"""What the planner thinks, made visible and told in sentences; pure, without a bus."""

from __future__ import annotations

from rogue.explain._decision import ROUTINE, Decision, DecisionKind, Rival
from rogue.explain._svg import draw_svg

__all__ = ["ROUTINE", "Decision", "DecisionKind", "Rival", "draw_svg"]
