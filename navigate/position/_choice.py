"""The localizers by their names."""

from __future__ import annotations

from typing import Literal

from navigate.maps import Floor
from navigate.messages import LocalizerName
from navigate.position._localizer import Localizer
from navigate.position._particles import ParticleFilter
from navigate.position._policy import Picking
from navigate.position._pomdp import PomdpLocalizer
from navigate.position._reckoning import DeadReckoning
from tca_bus import ConfigError

DEFAULT: LocalizerName = "pomdp"
"""The papers' own; the others are yardsticks."""

Start = Literal["known", "anywhere"]
"""Where the robot is to begin with: where the map says, or anywhere on it."""


def make_localizer(
    name: LocalizerName,
    floor: Floor,
    *,
    seed: int = 0,
    policy: Picking = "voting",
    start: Start = "known",
) -> Localizer:
    """The localizer of that name.

    ``seed`` is of its random numbers, if it draws any; ``policy`` picks what a lost robot is
    advised to do, if it gives advice.

    Raises:
        ConfigError: it does not find a robot that may be anywhere.
    """
    if start == "anywhere" and name != "pomdp":
        expected = f"known, or --localizer pomdp: {name} finds no robot that may be anywhere"
        raise ConfigError("--start", start, expected)
    if name == "odometry":
        return DeadReckoning(floor)
    if name == "pomdp":
        return PomdpLocalizer(floor, known=start == "known", picking=policy)
    return ParticleFilter(floor, seed=seed)
