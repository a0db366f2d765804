"""Which of several modules that handle one query is asked: fair, and without asking around."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

from tca_bus._presence import PresentModule


class Choice:
    """Chooses the module with the fewest of this caller's requests under way.

    Among equals the one that was chosen longest ago has its turn, so that a caller that asks one
    thing after the other goes round. What other callers have under way is not known here; a
    module at its capacity says so, and is not chosen while ``busy`` names it.
    """

    def __init__(self) -> None:
        self._under_way: dict[str, int] = {}
        self._last_turn: dict[str, int] = {}
        self._turns = itertools.count(1)

    def choose(
        self, candidates: Iterable[PresentModule], *, busy: Iterable[str] = ()
    ) -> PresentModule | None:
        """The module to ask; None when all candidates are in ``busy``, by incarnation."""
        excluded = set(busy)
        free = [one for one in candidates if one.incarnation not in excluded]
        return min(free, key=self._rank, default=None)

    def began(self, incarnation: str) -> None:
        """A request to a module is under way."""
        self._under_way[incarnation] = self._under_way.get(incarnation, 0) + 1
        self._last_turn[incarnation] = next(self._turns)

    def ended(self, incarnation: str) -> None:
        """A request to a module is over, however it ended."""
        left = self._under_way.pop(incarnation, 0) - 1
        if left > 0:
            self._under_way[incarnation] = left

    def forget(self, incarnation: str) -> None:
        """A module is gone for good."""
        self._last_turn.pop(incarnation, None)

    def _rank(self, module: PresentModule) -> tuple[int, int, str]:
        key = module.incarnation
        return self._under_way.get(key, 0), self._last_turn.get(key, 0), module.name
