"""A navigator from a floor plan: what the entry point ``xavier.navigators`` names."""

from __future__ import annotations

from typing import cast, get_args

from navigate.maps import Floor
from navigate.navigator import Navigator
from navigate.position import DEFAULT_LOCALIZER, LocalizerName, make_localizer
from tca_bus import TcaError, did_you_mean
from xavier_sim.messages import FloorPlan


class UnknownLocalizerError(TcaError, LookupError):
    """There is no localizer of that ``name``; ``known`` are those that there are."""

    exit_code = 2

    def __init__(self, name: str) -> None:
        self.name, self.known = name, tuple(sorted(get_args(LocalizerName)))
        hint = did_you_mean(name, self.known)
        super().__init__(f"localizer {name!r} is none of {', '.join(self.known)}.{hint}")


def make_navigator(
    plan: FloorPlan, *, seed: int = 0, localizer: str = DEFAULT_LOCALIZER
) -> Navigator:
    """The navigator's core for a floor as it was surveyed, without a network.

    Raises:
        UnknownLocalizerError: there is no localizer of that name.
    """
    if localizer not in get_args(LocalizerName):
        raise UnknownLocalizerError(localizer)
    floor, name = Floor(plan), cast("LocalizerName", localizer)
    return Navigator(floor, localizer=make_localizer(name, floor, seed=seed))
