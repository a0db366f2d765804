"""The best tour over a few errands, by dynamic programming over what is done of each.

Each errand is waiting, carried or delivered: a state is a number in base three. For each state
and the errand that was seen to last, what is left costs a certain least. With k errands that is
``k * 3**k`` figures, each of which comes from those with one step less to do.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rogue.errands._tour import Setting

EXACT_UP_TO = 8
"""Errands over which the best tour is found exactly."""

Ints = npt.NDArray[np.intp]
Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Stage:
    """The states in which as many steps are done; one row for each, one column an errand.

    Attributes:
        states: The states.
        after: The state that seeing to an errand leads to.
        stop: Where the errand is seen to next.
        is_open: Whether there is something left to do for it.
        places: Where the robot stands if it was seen to last.
        legs: For each errand seen to next, the ways there by state and errand seen to last, as
            indices into the flat array of seconds.
    """

    states: Ints
    after: Ints
    stop: Ints
    is_open: Bools
    places: Ints
    legs: tuple[Ints, ...]


@dataclass(frozen=True, slots=True)
class Lattice:
    """The states over a number of errands: what is done of each, and by how many steps."""

    digits: Ints
    stages: tuple[Stage, ...]


@functools.lru_cache(maxsize=EXACT_UP_TO + 2)
def lattice(count: int) -> Lattice:
    """The states over ``count`` errands."""
    errands = np.arange(count)
    digits = np.arange(3**count)[:, None] // 3**errands % 3
    done = digits.sum(axis=1)
    stages = []
    for amount in range(2 * count + 1):
        states = np.flatnonzero(done == amount)
        here = digits[states]
        is_open = here < 2
        after = np.where(is_open, states[:, None] + 3**errands, states[:, None])
        stop = errands + count * (here == 1)
        places = errands + count * (here == 2)
        rows = places * (2 * count + 1)
        legs = tuple(rows + stop[:, errand, None] for errand in range(count))
        stages.append(Stage(states, after, stop, is_open, places, legs))
    return Lattice(digits, tuple(stages))


class Board:
    """A setting laid out over states.

    Attributes:
        setting: What it was made of.
        count: Errands.
        lattice: The states.
        begin: The state at first.
        allowed: The states that the tray can hold.
        rate: What a second costs in each state.
    """

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self.count = len(setting.errands)
        self.lattice = lattice(self.count)
        carried = np.array([e.carried for e in setting.errands])
        self.begin = int((3 ** np.arange(self.count))[carried].sum())
        on_tray = self.lattice.digits == 1
        fits = on_tray.sum(axis=1) <= setting.capacity
        self.allowed = fits | ~(on_tray & ~carried).any(axis=1)
        self.rate = 1.0 + (self.lattice.digits < 2) @ setting.weights

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The stages behind the first step."""
        return self.lattice.stages[self.done + 1 :]

    @property
    def done(self) -> int:
        """Steps that are done at first."""
        return int(self.lattice.digits[self.begin].sum())

    def openings(self) -> tuple[Ints, Ints, Floats]:
        """The first steps: states after them, errands, and seconds to get there."""
        digits = self.lattice.digits[self.begin]
        errands = np.flatnonzero(digits < 2)
        after = self.begin + 3**errands
        fits = self.allowed[after]
        errands, after = errands[fits], after[fits]
        stops = errands + self.count * (digits[errands] == 1)
        return after, errands, self.setting.seconds[-1, stops]

    def legs(self, stage: Stage) -> Iterator[Floats]:
        """For each errand seen to next: seconds by state and errand seen to last."""
        seconds = self.setting.seconds.ravel()
        for index in stage.legs:
            yield seconds.take(index)

    def beyond(self, stage: Stage) -> Bools:
        """What cannot be done next, by state and errand."""
        possible: Bools = stage.is_open & self.allowed[stage.after]
        return ~possible

    def table(self, value: float) -> Floats:
        """One figure for each state and errand seen to last."""
        return np.full((len(self.lattice.digits), self.count), value)


def cost_to_go(board: Board) -> Floats:
    """The least that the rest costs, by state and errand seen to last, without deadlines."""
    rest = board.table(0.0)
    for stage in reversed(board.stages[:-1]):
        behind = rest[stage.after, np.arange(board.count)]
        behind[board.beyond(stage)] = np.inf
        rate = board.rate[stage.states, None]
        ways = (
            legs * rate + behind[:, errand, None] for errand, legs in enumerate(board.legs(stage))
        )
        rest[stage.states] = functools.reduce(np.minimum, ways)
    return rest


def cheapest_order(board: Board, rest: Floats) -> list[int]:
    """The cheapest order of stops without deadlines; ``rest`` is `cost_to_go`."""
    seconds, digits = board.setting.seconds, board.lattice.digits
    state, here = board.begin, 2 * board.count
    order: list[int] = []
    while len(order) < 2 * board.count - board.done:
        errands = np.flatnonzero(digits[state] < 2)
        after = state + 3**errands
        stops = errands + board.count * (digits[state, errands] == 1)
        ways = seconds[here, stops] * board.rate[state] + rest[after, errands]
        best = int(np.where(board.allowed[after], ways, np.inf).argmin())
        state, here = int(after[best]), int(stops[best])
        order.append(here)
    return order


def latest_times(board: Board, deadlines: Floats) -> Floats:
    """Until when one may be in each state so that the rest can still be done in time."""
    latest = board.table(np.inf)
    for stage in reversed(board.stages[:-1]):
        due = np.where(stage.stop >= board.count, deadlines, np.inf)
        due = np.minimum(due, latest[stage.after, np.arange(board.count)])
        due[board.beyond(stage)] = -np.inf
        ways = (due[:, errand, None] - legs for errand, legs in enumerate(board.legs(stage)))
        latest[stage.states] = functools.reduce(np.maximum, ways)
    return latest


def earliest_times(board: Board, deadlines: Floats) -> Floats:
    """When one can be in each state at the earliest, no deadline missed on the way."""
    earliest = board.table(np.inf)
    after, errands, legs = board.openings()
    digits, now = board.lattice.digits, board.setting.now
    late = (digits[after, errands] == 2) & (now + legs > deadlines[errands])
    earliest[after, errands] = np.where(late, np.inf, now + legs)
    for stage in board.stages[:-1]:
        here = earliest[stage.states]
        found = np.stack([(here + legs).min(axis=1) for legs in board.legs(stage)], axis=1)
        late = (stage.stop >= board.count) & (found > deadlines)
        found = np.where(late | ~board.allowed[stage.after], np.inf, found)
        row, errand = np.nonzero(stage.is_open)
        earliest[stage.after[row, errand], errand] = found[row, errand]
    return earliest


def can_be_met(board: Board, latest: Floats) -> bool:
    """Whether all deadlines can be met; ``latest`` is `latest_times`."""
    return bool(first_steps_in_time(board, latest).any())


def first_steps_in_time(board: Board, latest: Floats) -> Bools:
    """Which of the first steps leave time for the rest."""
    after, errands, legs = board.openings()
    return board.setting.now + legs <= latest[after, errands]


def earliest_completion(setting: Setting, errand: int) -> float:
    """When ``errand`` can be delivered at the earliest with all others in time.

    Its own deadline does not count. Infinity if the others cannot all be in time.
    """
    board = Board(setting)
    deadlines = setting.deadlines.copy()
    deadlines[errand] = np.inf
    delivered = board.lattice.digits[:, errand] == 2
    when = earliest_times(board, deadlines)[delivered, errand]
    found = when[when <= latest_times(board, deadlines)[delivered, errand]]
    return float(found.min()) if found.size else float("inf")
