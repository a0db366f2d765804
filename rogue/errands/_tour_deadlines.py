"""The best tour over a few errands of which some are due.

Which deadlines are given up comes first, since one more that is met outweighs any detour. Then
all ways are followed at once, step by step. Of those that come to one place with the same things
done, one that is neither cheaper nor earlier than another is left; and so is one that comes too
late for the rest, or costs more with what the rest costs at least than a tour that is known.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from rogue.errands._tour import Setting, Tour
from rogue.errands._tour_exact import (
    Board,
    Bools,
    Floats,
    Ints,
    can_be_met,
    cheapest_order,
    cost_to_go,
    first_steps_in_time,
    latest_times,
)

BEAM = 100
"""Ways followed for a first tour, whose cost bounds those that are followed for the best."""

MOST_WAYS = 20_000
"""Ways followed at once; of more the best, and the tour may not be the best then."""

MOST_CHOICES = 12
"""Choices of deadlines to give up that are looked at."""


def exact_tour(setting: Setting) -> Tour:
    """The tour of least cost.

    Where so many deadlines cannot be met that not all choices can be looked at, it is a good one,
    and says so.
    """
    board = Board(setting)
    rest = cost_to_go(board)
    tour = setting.tour(cheapest_order(board, rest), is_exact=True)
    if not tour.late:
        return tour
    choices = _choices(board)
    found, paid = _in_turn(board, rest, choices[:MOST_CHOICES])
    if not found:
        found = [one for one in (_with_deadlines(board, rest, choices[-1][1]), tour) if one]
    best = min(found, key=lambda one: one.cost)
    is_whole = all(penalty > paid for penalty, _ in choices[MOST_CHOICES:])
    return replace(best, is_exact=best.is_exact and is_whole)


def _in_turn(
    board: Board, rest: Floats, choices: list[tuple[float, tuple[int, ...]]]
) -> tuple[list[Tour], float]:
    """The best tours of the cheapest choices that can be done, all equally cheap, and the price."""
    found: list[Tour] = []
    paid = np.inf
    for penalty, given_up in choices:
        if penalty > paid:
            break
        tour = _with_deadlines(board, rest, given_up)
        if tour is not None:
            found.append(tour)
            paid = penalty
    return found, paid


def _with_deadlines(board: Board, rest: Floats, given_up: tuple[int, ...]) -> Tour | None:
    """The best tour in which only some are late; None if there is none."""
    deadlines = board.setting.deadlines.copy()
    deadlines[list(given_up)] = np.inf
    latest = latest_times(board, deadlines)
    if not can_be_met(board, latest):
        return None
    search = _Search(board, deadlines, latest, rest)
    first, _ = search.run(BEAM, np.inf)
    order, is_whole = search.run(MOST_WAYS, search.cost(first))
    return board.setting.tour(order, is_exact=is_whole)


def _choices(board: Board) -> list[tuple[float, tuple[int, ...]]]:
    """Penalties and errands to give up together, the cheapest first; the last can be done."""
    setting = board.setting
    hopeless = [e for e in range(board.count) if _alone(setting, e) > setting.deadlines[e]]
    due = [e for e in range(board.count) if e not in hopeless and setting.deadlines[e] < np.inf]
    enough = (*hopeless, *_too_many(board, due))
    most = _penalty(board, enough)
    sets = [
        (*hopeless, *more)
        for size in range(len(due) + 1)
        for more in itertools.combinations(due, size)
    ]
    choices = sorted(c for c in ((_penalty(board, one), one) for one in sets) if c[0] <= most)
    return [*(c for c in choices if c[1] != enough), (most, enough)]


def _penalty(board: Board, errands: tuple[int, ...]) -> float:
    return sum(board.setting.penalty(e) for e in errands)


def _too_many(board: Board, due: list[int]) -> list[int]:
    """Errands whose deadlines cannot be met with those of the dearer and earlier ones."""
    setting = board.setting
    deadlines = np.full(board.count, np.inf)
    left = []
    for errand in sorted(due, key=lambda e: (-setting.penalty(e), setting.deadlines[e])):
        deadlines[errand] = setting.deadlines[errand]
        if not can_be_met(board, latest_times(board, deadlines)):
            deadlines[errand] = np.inf
            left.append(errand)
    return sorted(left)


def _alone(setting: Setting, errand: int) -> float:
    deliver = len(setting.errands) + errand
    if setting.errands[errand].carried:
        return setting.now + float(setting.seconds[-1, deliver])
    fetch = setting.seconds[-1, errand] + setting.seconds[errand, deliver]
    return setting.now + float(fetch)


@dataclass(frozen=True, slots=True)
class _Ways:
    """Ways of as many steps, one a row: where they lead, and the row of the way before."""

    state: Ints
    errand: Ints
    cost: Floats
    time: Floats
    before: Ints

    def kept(self, rows: Ints) -> _Ways:
        return _Ways(
            self.state[rows], self.errand[rows], self.cost[rows], self.time[rows], self.before[rows]
        )


class _Search:
    def __init__(self, board: Board, deadlines: Floats, latest: Floats, rest: Floats) -> None:
        self._board = board
        self._deadlines = deadlines
        self._latest = latest
        self._rest = rest

    def cost(self, order: list[int]) -> float:
        """Cost of an order without that of what is late."""
        setting, here, cost = self._board.setting, -1, 0.0
        state = self._board.begin
        for stop in order:
            leg = float(setting.seconds[here, stop])
            cost += leg * float(self._board.rate[state])
            here = stop
            state += 3 ** (stop % self._board.count)
        return cost

    def run(self, most: int, bound: float) -> tuple[list[int], bool]:
        """The best order of stops, and whether all ways that might be better were followed."""
        board, is_whole = self._board, True
        waves = [self._first()]
        for _ in board.stages[:-1]:
            ways = self._undominated(self._in_time(self._next(waves[-1]), bound))
            if len(ways.state) > most:
                is_whole = False
                rest = ways.cost + self._rest[ways.state, ways.errand]
                ways = ways.kept(np.argpartition(rest, most)[:most])
            waves.append(ways)
        return self._unwind(waves), is_whole

    def _first(self) -> _Ways:
        board = self._board
        after, errands, legs = board.openings()
        time = board.setting.now + legs
        fits = first_steps_in_time(board, self._latest) & self._is_due(after, errands, time)
        ways = _Ways(after, errands, legs * board.rate[board.begin], time, np.full(len(after), -1))
        return ways.kept(np.flatnonzero(fits))

    def _next(self, ways: _Ways) -> _Ways:
        """Every way with one more step, whatever comes of it."""
        board, digits = self._board, self._board.lattice.digits
        row, errand = np.nonzero(digits[ways.state] < 2)
        state, last = ways.state[row], ways.errand[row]
        here = last + board.count * (digits[state, last] == 2)
        stop = errand + board.count * (digits[state, errand] == 1)
        legs = board.setting.seconds[here, stop]
        return _Ways(
            state + 3**errand,
            errand,
            ways.cost[row] + legs * board.rate[state],
            ways.time[row] + legs,
            row,
        )

    def _in_time(self, ways: _Ways, bound: float) -> _Ways:
        least = ways.cost + self._rest[ways.state, ways.errand]
        fits = self._board.allowed[ways.state] & (least <= bound * (1.0 + 1e-12))
        fits &= ways.time <= self._latest[ways.state, ways.errand]
        fits &= self._is_due(ways.state, ways.errand, ways.time)
        return ways.kept(np.flatnonzero(fits))

    def _is_due(self, state: Ints, errand: Ints, time: Floats) -> Bools:
        delivered = self._board.lattice.digits[state, errand] == 2
        due: Floats = np.where(delivered, self._deadlines[errand], np.inf)
        return time <= due

    def _undominated(self, ways: _Ways) -> _Ways:
        place = ways.state * self._board.count + ways.errand
        ways = ways.kept(np.lexsort((ways.cost, ways.time, place)))
        place = ways.state * self._board.count + ways.errand
        group = np.cumsum(np.diff(place, prepend=-1) != 0)
        apart = float(ways.cost.max(initial=0.0)) + 1.0
        lowered = ways.cost - group * apart
        best = np.minimum.accumulate(lowered)
        is_best = np.ones(len(place), dtype=np.bool_)
        is_best[1:] = lowered[1:] < best[:-1]
        return ways.kept(np.flatnonzero(is_best))

    def _unwind(self, waves: list[_Ways]) -> list[int]:
        board, row = self._board, int(waves[-1].cost.argmin())
        order: list[int] = []
        for ways in reversed(waves):
            state, errand = int(ways.state[row]), int(ways.errand[row])
            order.append(errand + board.count * int(board.lattice.digits[state, errand] == 2))
            row = int(ways.before[row])
        return order[::-1]
