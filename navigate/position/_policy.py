"""Which directive to give on a belief: by vote, by the most likely state, or by QMDP.

Each state has a best directive, from the costs of getting to the goal if the state were known.
*Voting* takes the directive for which the most mass speaks; *mls* that of the most likely state;
*qmdp* the one of the least expected cost, as if the state were known after it. After Simmons &
Koenig (1995), Cassandra, Kaelbling & Kurien (1996), and Littman, Cassandra & Kaelbling (1995).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import ClassVar, Literal, assert_never

import numpy as np
from numpy.typing import NDArray

from navigate.maps import Floats, Point
from navigate.position._markov import TURNS, Indices, MarkovModel

Picking = Literal["voting", "mls", "qmdp"]

FORWARD_SECONDS = 2.0
"""What a metre costs."""

TURN_SECONDS = 3.0
"""What a quarter of a turn costs."""

TOO_FAR = 3600.0
"""Cost of a state from which there is no way to the goal, seconds."""

STOP_BESIDE = 600.0
"""Cost of stopping where the goal is not, seconds."""

AT_GOAL = 0.9
"""Metres from a goal within which a location is at it; the nearest is in any case."""

SETTLED = 0.01
"""Seconds by which the last sweep changes costs at most."""

SWEEPS = 12
"""Sweeps over all states in a tick: a new goal's policy is there after one or two seconds."""


class Directive(enum.IntEnum):
    """What the navigation layer tells the layer that drives."""

    FORWARD = 0
    """A metre on."""
    LEFT = 1
    """A quarter of a turn to the left."""
    RIGHT = 2
    STOP = 3


@dataclass(frozen=True, slots=True)
class Choice:
    """A directive, and the mass of the states for which it is the best, 0 to 1."""

    directive: Directive
    share: float


class Policy:
    """The way to one goal from every state, worked out a little at a time.

    Args:
        model: states and motions.
    """

    STATE: ClassVar[tuple[str, ...]] = ("goal", "costs", "settled")

    def __init__(self, model: MarkovModel) -> None:
        self._model = model
        self._derived: tuple[Floats, Floats, Indices] | None = None
        self.drop()

    def drop(self) -> None:
        """Have no goal."""
        self.goal: Point | None = None
        self.costs: Floats = np.full(self._model.size, TOO_FAR)
        self.settled = False

    def aim(self, goal: Point) -> None:
        """Begin on the way to a point in metres, the locations at which are the goal."""
        self.drop()
        self.goal = goal
        self.costs[self._reached(goal)] = 0.0

    def work(self, sweeps: int = SWEEPS) -> bool:
        """Go on with the costs to the goal, by value iteration; whether they have settled."""
        for _ in range(sweeps):
            if self.settled:
                break
            after = np.minimum(self.costs, self._moving(self.costs).min(axis=0))
            self.settled = float(np.abs(after - self.costs).max()) <= SETTLED
            self.costs = after
        return self.settled

    @property
    def best(self) -> Indices:
        """The number of the best `Directive` in each state."""
        return self._directives()[1]

    def choose(self, chances: Floats, *, picking: Picking = "voting") -> Choice:
        """The directive to give on a belief: ``chances`` of all states, which sum up to 1."""
        values, best = self._directives()
        votes = np.bincount(best, weights=chances, minlength=len(Directive))
        match picking:
            case "voting":
                pick = int(votes.argmax())
            case "mls":
                pick = int(best[chances.argmax()])
            case "qmdp":
                pick = int((values @ chances).argmin())
            case _:
                assert_never(picking)
        return Choice(Directive(pick), float(votes[pick]))

    def _reached(self, goal: Point) -> NDArray[np.bool_]:
        """Which states are at the goal."""
        at = self._model.locations.at
        away = np.hypot(at[:, 0] - goal[0], at[:, 1] - goal[1])
        return np.tile(away <= max(float(away.min()), AT_GOAL), TURNS)

    def _moving(self, costs: Floats) -> Floats:
        """The cost of each directive that moves: shape (3, states)."""
        by_heading = costs.reshape(TURNS, -1)
        moving = np.empty((3, TURNS, by_heading.shape[1]))
        moving[0] = self._model.ahead(costs).reshape(TURNS, -1)
        moving[0] += FORWARD_SECONDS
        moving[1, :-1], moving[1, -1] = by_heading[1:], by_heading[0]
        moving[2, 1:], moving[2, 0] = by_heading[:-1], by_heading[-1]
        moving[1:] += TURN_SECONDS
        return moving.reshape(3, -1)

    def _directives(self) -> tuple[Floats, Indices]:
        """The cost of each directive in each state, shape (4, states), and which is the best."""
        if self._derived is None or self._derived[0] is not self.costs:
            stopping = np.where(self.costs == 0.0, 0.0, STOP_BESIDE)
            values = np.concatenate([self._moving(self.costs), stopping[None]])
            self._derived = (self.costs, values, values.argmin(axis=0))
        return self._derived[1], self._derived[2]
