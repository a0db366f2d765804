"""A good tour over many errands: cheapest insertion, then errands moved to better places.

All places for a pickup and a delivery are weighed at once, from the delays that they cause to
what comes behind them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rogue.errands._tour import Setting, Tour

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Place:
    """Where an errand goes into an order of stops, and what that costs.

    ``pickup`` and ``deliver`` count the stops of the order before them; ``completion`` is when
    the errand is then delivered, ``meets_others`` whether no other misses its deadline by it.
    """

    pickup: int
    deliver: int
    cost: float
    completion: float
    meets_others: bool


class Line:
    """An order of stops with what inserting something between them needs to know."""

    def __init__(self, setting: Setting, order: Sequence[int]) -> None:
        self.setting = setting
        self.order = list(order)
        count = len(setting.errands)
        nodes = np.array([2 * count, *order], dtype=np.intp)
        errand, is_delivery = nodes % count, (nodes >= count) & (nodes < 2 * count)
        self._nodes = nodes
        self._legs = setting.seconds[nodes[:-1], nodes[1:]]
        self.done = setting.now + np.concatenate([[0.0], self._legs.cumsum()])
        weights = np.where(is_delivery, setting.weights[errand], 0.0)
        self._behind = weights[::-1].cumsum()[::-1] - weights
        slack = np.where(is_delivery, setting.deadlines[errand] - self.done, np.inf)
        self._slack = np.where(slack < 0.0, np.inf, slack)
        carried = sum(one.carried for one in setting.errands)
        change = np.where(nodes < count, 1, np.where(is_delivery, -1, 0))
        self._load = carried + change.cumsum()

    def without(self, errand: int) -> Line:
        """This order without the stops of an errand."""
        count = len(self.setting.errands)
        return Line(self.setting, [stop for stop in self.order if stop % count != errand])

    def with_(self, errand: int, place: Place) -> Line:
        """This order with the stops of an errand put in."""
        count = len(self.setting.errands)
        order = list(self.order)
        order.insert(place.deliver, count + errand)
        if not self.setting.errands[errand].carried:
            order.insert(place.pickup, errand)
        return Line(self.setting, order)

    def best_place(self, errand: int) -> Place:
        """Where an errand costs least."""
        return self._places(errand).cheapest()

    def soonest_place(self, errand: int) -> Place:
        """Where an errand is delivered soonest without another missing its deadline."""
        return self._places(errand).soonest()

    def _places(self, errand: int) -> _Places:
        if self.setting.errands[errand].carried:
            return self._for_delivery(errand)
        return self._for_both(errand)

    def _detours(self, stop: int) -> tuple[Floats, Floats]:
        """Seconds to go to ``stop`` from each node, and what the detour there costs all behind."""
        to, back = self.setting.seconds[self._nodes, stop], self.setting.seconds[stop, self._nodes]
        detour = to.copy()
        detour[:-1] += back[1:] - self._legs
        return to, detour

    def _for_delivery(self, errand: int) -> _Places:
        to, detour = self._detours(len(self.setting.errands) + errand)
        completion = self.done + to
        ahead = np.minimum.accumulate(np.append(self._slack[1:], np.inf)[::-1])[::-1]
        cost = detour * (1.0 + self._behind)
        # Until then the item is on the tray, where others may be put beside it.
        cost[np.maximum.accumulate(self._load) > self.setting.capacity] = np.inf
        return _Places(self.setting, errand, cost[None], completion[None], (ahead >= detour)[None])

    def _for_both(self, errand: int) -> _Places:
        setting, count, size = self.setting, len(self.setting.errands), len(self._nodes)
        to_pickup, first = self._detours(errand)
        to_deliver, second = self._detours(count + errand)
        between = setting.seconds[errand, count + errand]
        completion = (self.done + to_deliver)[None, :] + first[:, None]
        delay = first[:, None] + second[None, :]
        cost = delay + first[:, None] * self._behind[:, None] + second * self._behind
        at = np.arange(size)
        completion[at, at] = self.done + to_pickup + between
        last = np.append(setting.seconds[count + errand, self._nodes[1:]] - self._legs, 0.0)
        both = to_pickup + between + last
        delay[at, at], cost[at, at] = both, both * (1.0 + self._behind)
        ahead = np.minimum.accumulate(np.append(self._slack[1:], np.inf)[::-1])[::-1]
        within = np.where(at[None, :] > at[:, None], self._slack[None, :], np.inf)
        within = np.minimum.accumulate(within, axis=1)
        meets = (within >= first[:, None]) & (ahead[None, :] >= delay)
        load = np.where(at[None, :] >= at[:, None], self._load[None, :], -count)
        fits = np.maximum.accumulate(load, axis=1) < setting.capacity
        cost[(at[None, :] < at[:, None]) | ~fits] = np.inf
        return _Places(setting, errand, cost, completion, meets)


class _Places:
    """All places for one errand: cost without deadlines, completion, whether others keep theirs."""

    def __init__(
        self,
        setting: Setting,
        errand: int,
        cost: Floats,
        completion: Floats,
        meets: npt.NDArray[np.bool_],
    ) -> None:
        own = setting.penalty(errand)
        late = completion > setting.deadlines[errand]
        total = cost + setting.weights[errand] * (completion - setting.now)
        total += np.where(late, own, 0.0)
        dearest = max(map(setting.penalty, range(len(setting.errands))))
        self._cost = total + np.where(meets, 0.0, dearest)
        self._completion, self._meets = completion, meets
        self._possible = np.isfinite(cost)

    def cheapest(self) -> Place:
        return self._place(int(self._cost.argmin()))

    def soonest(self) -> Place:
        possible = self._possible & self._meets
        if not possible.any():
            return self.cheapest()
        return self._place(int(np.where(possible, self._completion, np.inf).argmin()))

    def _place(self, at: int) -> Place:
        row, column = divmod(at, self._cost.shape[1])
        return Place(
            row,
            column,
            float(self._cost.flat[at]),
            float(self._completion.flat[at]),
            bool(self._meets.flat[at]),
        )


def kept_line(setting: Setting, order: Sequence[tuple[str, bool]]) -> tuple[Line, list[int]]:
    """What remains of an earlier order, given by key and is-delivery, and the errands not in it."""
    count = len(setting.errands)
    index = {one.key: at for at, one in enumerate(setting.errands)}
    known = set(order)
    kept = {
        at
        for key, at in index.items()
        if (key, True) in known and (setting.errands[at].carried or (key, False) in known)
    }
    stops = [
        index[key] + count * is_delivery
        for key, is_delivery in order
        if index.get(key) in kept and (is_delivery or not setting.errands[index[key]].carried)
    ]
    return Line(setting, stops), [at for at in range(count) if at not in kept]


def grown(line: Line, new: Iterable[int]) -> Line:
    """The line with new errands, each put in where it costs least.

    What is on the tray comes first: on a full one there is no place for anything else before.
    """
    for errand in sorted(new, key=lambda at: not line.setting.errands[at].carried):
        line = line.with_(errand, line.best_place(errand))
    return line


def improved(line: Line, errands: Iterable[int]) -> tuple[Line, Tour]:
    """The line with each of ``errands`` moved to where it costs less, and its tour."""
    best = line.setting.tour(line.order, is_exact=False)
    for errand in errands:
        shorter = line.without(errand)
        other = shorter.with_(errand, shorter.best_place(errand))
        tour = line.setting.tour(other.order, is_exact=False)
        if tour.cost < best.cost:
            line, best = other, tour
    return line, best
