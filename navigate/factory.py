"""A navigator from a floor plan: what the entry point ``xavier.navigators`` names."""

from __future__ import annotations

from navigate.maps import Floor
from navigate.navigator import Navigator
from navigate.position import LocalizerName, make_localizer
from xavier_sim.messages import FloorPlan


def make_navigator(
    plan: FloorPlan, *, seed: int = 0, localizer: LocalizerName = "particles"
) -> Navigator:
    """The navigator's core for a floor as it was surveyed, without a network."""
    floor = Floor(plan)
    return Navigator(floor, localizer=make_localizer(localizer, floor, seed=seed))
