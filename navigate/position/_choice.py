"""The localizers by their names."""

from __future__ import annotations

from navigate.maps import Floor
from navigate.messages import LocalizerName
from navigate.position._localizer import Localizer
from navigate.position._particles import ParticleFilter
from navigate.position._policy import Picking
from navigate.position._pomdp import PomdpLocalizer
from navigate.position._reckoning import DeadReckoning

DEFAULT: LocalizerName = "pomdp"
"""The papers' own; the others are yardsticks."""


def make_localizer(
    name: LocalizerName, floor: Floor, *, seed: int = 0, policy: Picking = "voting"
) -> Localizer:
    """The localizer of that name.

    ``seed`` is of its random numbers, if it draws any; ``policy`` picks what a lost robot is
    advised to do, if it gives advice.
    """
    if name == "odometry":
        return DeadReckoning(floor)
    if name == "pomdp":
        return PomdpLocalizer(floor, picking=policy)
    return ParticleFilter(floor, seed=seed)
