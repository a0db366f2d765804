"""A navigator from a floor plan: what the entry point ``xavier.navigators`` names."""

from __future__ import annotations

from typing import cast, get_args

from navigate.maps import Floor
from navigate.messages import LocalizerName
from navigate.navigator import Navigator
from navigate.position import DEFAULT_LOCALIZER, Picking, make_localizer
from tca_bus import TcaError, did_you_mean
from xavier_sim.messages import FloorPlan


class UnknownChoiceError(TcaError, LookupError):
    """There is no ``what``, a localizer say, of that ``name``; ``known`` are all there are."""

    exit_code = 2

    def __init__(self, what: str, name: str, known: tuple[str, ...]) -> None:
        self.what, self.name, self.known = what, name, tuple(sorted(known))
        hint = did_you_mean(name, self.known)
        super().__init__(f"{what} {name!r} is none of {', '.join(self.known)}.{hint}")


def make_navigator(
    plan: FloorPlan,
    *,
    seed: int = 0,
    localizer: str = DEFAULT_LOCALIZER,
    policy: str = "voting",
) -> Navigator:
    """The navigator's core for a floor as it was surveyed, without a network.

    Raises:
        UnknownChoiceError: there is no localizer, or no policy, of that name.
    """
    for what, name, known in (
        ("localizer", localizer, get_args(LocalizerName)),
        ("policy", policy, get_args(Picking)),
    ):
        if name not in known:
            raise UnknownChoiceError(what, name, known)
    floor, picking = Floor(plan), cast("Picking", policy)
    chosen = make_localizer(cast("LocalizerName", localizer), floor, seed=seed, policy=picking)
    return Navigator(floor, localizer=chosen)
