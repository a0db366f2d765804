"""When open requests will be done, as far as can be told: from the tour over all of them."""

from __future__ import annotations

import math
from collections.abc import Iterable

from rogue.errands import OpenErrand, Promise, RunningTour, Travel
from rogue.memory import Facts
from rogue.messages import DeliveryRequest
from rogue.requests._endings import is_carried

MOVES = 1
"""Errands that are tried elsewhere at each change of a long tour: it is only looked at."""

MADE_ANEW = 40
"""Up to so many errands the tour is made anew each time, and depends on nothing earlier."""


class Outlook:
    """The tour that the robot is expected to make."""

    def __init__(self) -> None:
        self._long: RunningTour | None = None

    def promise(
        self,
        request: DeliveryRequest,
        others: Iterable[DeliveryRequest],
        *,
        travel: Travel,
        facts: Facts,
        now: float,
    ) -> Promise:
        """When a new request can be done, with all that was accepted before.

        Args:
            request: the new one.
            others: those that are open.
            travel: how fast the robot is, and how far the rooms are apart.
            facts: where the robot is, what is on its tray.
            now: seconds since the epoch.
        """
        errands = [_errand(other, facts) for other in others]
        tour = self._tour(len(errands), travel)
        if tour is not self._long:
            tour.update(errands, start=facts.room, now=now)
        return tour.promise(_errand(request, facts), errands, start=facts.room, now=now)

    def expected(
        self, requests: Iterable[DeliveryRequest], *, travel: Travel, facts: Facts, now: float
    ) -> dict[str, float]:
        """When open requests will be done, by their ids; arguments as those of `promise`."""
        errands = [_errand(request, facts) for request in requests]
        tour = self._tour(len(errands), travel).update(errands, start=facts.room, now=now)
        return {stop.key: stop.done for stop in tour.stops if stop.is_delivery}

    def _tour(self, count: int, travel: Travel) -> RunningTour:
        if count <= MADE_ANEW:
            self._long = None
            return RunningTour(travel)
        self._long = self._long or RunningTour(travel, moves=MOVES)
        return self._long


def _errand(request: DeliveryRequest, facts: Facts) -> OpenErrand:
    """A request as a tour sees it; one that is given up only has to leave the tray."""
    return OpenErrand(
        key=request.id,
        pickup=request.pickup,
        deliver=request.destination,
        rank=float(request.rank),
        deadline=math.inf if request.closing else request.deadline,
        carried=is_carried(request, facts),
    )
