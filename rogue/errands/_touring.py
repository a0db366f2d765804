"""Tours as they are asked for: the best one, one that grows with the errands, and promises."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import inf

from rogue.errands._tour import EMPTY, OpenErrand, Rooms, Setting, Tour, Travel
from rogue.errands._tour_deadlines import exact_tour
from rogue.errands._tour_exact import EXACT_UP_TO, earliest_completion
from rogue.errands._tour_insertion import Line, grown, improved, kept_line

MOVES = 4
"""Errands that are tried elsewhere at each change of a long tour."""

ROUNDS = 4
"""How often all errands are tried elsewhere in a long tour that is made at once."""


def best_tour(
    errands: Iterable[OpenErrand], *, start: str | None, travel: Travel, now: float = 0.0
) -> Tour:
    """The best tour over errands: exact up to `EXACT_UP_TO`, beyond it as good as moves make it.

    It depends on nothing but its arguments: whoever asks again gets the same.

    Args:
        errands: In any order.
        start: Room of the robot; None if nobody knows where that is.
        travel: Distances, speed, tray, weights.
        now: Seconds, as the deadlines are.
    """
    listed = tuple(errands)
    if not listed:
        return EMPTY
    setting = Setting.of(listed, start=start, travel=travel, now=now)
    if len(listed) <= EXACT_UP_TO:
        return exact_tour(setting)
    orders = (_by_due_time(setting), _by_rank(setting))
    return min((_settled(setting, order) for order in orders), key=lambda tour: tour.cost)


def _settled(setting: Setting, order: Sequence[int]) -> Tour:
    """The tour into which errands are put in this order, and then moved while it gets better."""
    line, tour = improved(grown(Line(setting, []), order), ())
    for _ in range(ROUNDS):
        before = tour.cost
        line, tour = improved(line, range(len(order)))
        if tour.cost >= before:
            break
    return tour


class RunningTour:
    """A tour that is kept while errands come and go.

    Up to `EXACT_UP_TO` errands it is the best there is. Beyond, what is new is put in where it
    costs least, and ``moves`` of the others are tried elsewhere, in turn.
    """

    def __init__(self, travel: Travel, *, moves: int = MOVES) -> None:
        self._travel = travel
        self._moves = moves
        self._rooms = Rooms(travel.distance)
        self._order: list[tuple[str, bool]] = []
        self._turn = 0

    def update(self, errands: Iterable[OpenErrand], *, start: str | None, now: float = 0.0) -> Tour:
        """The tour over these errands; arguments as those of `best_tour`."""
        listed = tuple(errands)
        if not listed:
            self._order.clear()
            return EMPTY
        setting = self._setting(listed, start, now)
        tour = exact_tour(setting) if len(listed) <= EXACT_UP_TO else self._grown(setting)
        self._order = [(stop.key, stop.is_delivery) for stop in tour.stops]
        return tour

    def promise(
        self,
        errand: OpenErrand,
        accepted: Iterable[OpenErrand],
        *,
        start: str | None,
        now: float = 0.0,
    ) -> Promise:
        """When a new errand can be delivered; arguments and answer as those of `promise`."""
        others = tuple(accepted)
        alone = exact_tour(self._setting((errand,), start, now)).completion(errand.key)
        if len(others) < EXACT_UP_TO:
            soonest = self._exact_completion(errand, others, start, now)
            return Promise(errand.deadline, alone, soonest)
        setting = self._setting((replace(errand, deadline=inf), *others), start, now)
        line, new = kept_line(setting, self._order)
        line = grown(line, (other for other in new if other)).without(0)
        return Promise(errand.deadline, alone, line.soonest_place(0).completion)

    def _exact_completion(
        self, errand: OpenErrand, others: tuple[OpenErrand, ...], start: str | None, now: float
    ) -> float:
        found = earliest_completion(self._setting((errand, *others), start, now), 0)
        if found < inf or not others:
            return found
        late = exact_tour(self._setting(others, start, now)).late
        freed = tuple(replace(e, deadline=inf) if e.key in late else e for e in others)
        return earliest_completion(self._setting((errand, *freed), start, now), 0)

    def _setting(self, errands: tuple[OpenErrand, ...], start: str | None, now: float) -> Setting:
        return Setting.of(errands, start=start, travel=self._travel, now=now, rooms=self._rooms)

    def _grown(self, setting: Setting) -> Tour:
        line, new = kept_line(setting, self._order)
        count = len(setting.errands)
        turns = [(self._turn + step) % count for step in range(min(self._moves, count))]
        self._turn = (self._turn + len(turns)) % count
        return improved(grown(line, new), turns)[1]


@dataclass(frozen=True, slots=True)
class Promise:
    """When an errand can be delivered at the earliest.

    Attributes:
        deadline: Until when it shall be.
        alone: If there were nothing else to do.
        earliest: With all accepted errands in time that would be without it.
    """

    deadline: float
    alone: float
    earliest: float

    @property
    def can_be_kept(self) -> bool:
        """Whether it can be delivered by its deadline."""
        return self.earliest <= self.deadline


def promise(
    errand: OpenErrand,
    accepted: Iterable[OpenErrand],
    *,
    start: str | None,
    travel: Travel,
    now: float = 0.0,
) -> Promise:
    """When a new errand can be delivered, given those that were accepted before.

    Exact while they are at most `EXACT_UP_TO` together; beyond, the new one is put into their
    tour where it is delivered soonest, so that ``earliest`` may be later than need be.

    Args:
        errand: The new one.
        accepted: The others; deadlines that cannot be met without the new one count no more.
        start: Room of the robot; None if nobody knows where that is.
        travel: Distances, speed, tray, weights.
        now: Seconds, as the deadlines are.
    """
    running = RunningTour(travel)
    others = tuple(accepted)
    running.update(others, start=start, now=now)
    return running.promise(errand, others, start=start, now=now)


def _by_due_time(setting: Setting) -> list[int]:
    return sorted(range(len(setting.errands)), key=lambda at: setting.errands[at].deadline)


def _by_rank(setting: Setting) -> list[int]:
    return sorted(range(len(setting.errands)), key=lambda at: -setting.errands[at].rank)
