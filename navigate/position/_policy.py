"""Which directive to give on a belief: by vote, by the most likely state, or by QMDP.

Each state has a best directive, from the costs of getting to the goal if the state were known.
*Voting* takes the directive for which the most mass speaks; *mls* that of the most likely state;
*qmdp* the one of the least expected cost, as if the state were known after it. After Simmons &
Koenig (1995), Cassandra, Kaelbling & Kurien (1996), and Littman, Cassandra & Kaelbling (1995).
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Literal, assert_never

import numpy as np
from numpy.typing import NDArray

from navigate.maps import Floats, Point
from navigate.position._markov import TURNS, MarkovModel

Picking = Literal["voting", "mls", "qmdp"]

FORWARD_SECONDS = 2.0
"""What a metre costs."""

TURN_SECONDS = 3.0
"""What a quarter of a turn costs."""

TOO_FAR = 3600.0
"""Cost of a state from which there is no way to the goal, seconds."""

STOP_BESIDE = 600.0
"""Cost of stopping where the goal is not, seconds."""

AT_GOAL = 0.8
"""Metres from a goal within which a location is at it; the nearest is in any case."""

SETTLED = 0.01
"""Seconds by which the last sweep changes costs at most."""

SWEEPS = 1000


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
    """The way to one goal from every state.

    Args:
        model: states and motions.
        goal: a point in metres; the locations at it are the goal.
    """

    def __init__(self, model: MarkovModel, goal: Point) -> None:
        self._model = model
        at = model.locations.at
        away = np.hypot(at[:, 0] - goal[0], at[:, 1] - goal[1])
        reached = away <= max(float(away.min()), AT_GOAL)
        self.goals: NDArray[np.bool_] = np.tile(reached, TURNS)
        self._leads = _Leads(model)
        self.costs = self._costs_to_go()
        self._values = self._directives()
        self.best: NDArray[np.intp] = self._values.argmin(axis=0)

    def choose(self, chances: Floats, *, picking: Picking = "voting") -> Choice:
        """The directive to give on a belief: ``chances`` of all states, which sum up to 1."""
        votes: Floats = np.zeros(len(Directive))
        np.add.at(votes, self.best, chances)
        directive = Directive(self._pick(chances, votes, picking))
        return Choice(directive, float(votes[directive]))

    def _pick(self, chances: Floats, votes: Floats, picking: Picking) -> int:
        match picking:
            case "voting":
                return int(votes.argmax())
            case "mls":
                return int(self.best[chances.argmax()])
            case "qmdp":
                return int((self._values @ chances).argmin())
            case _:
                assert_never(picking)

    def _costs_to_go(self) -> Floats:
        """Seconds to the goal from each state, by value iteration."""
        costs = np.where(self.goals, 0.0, TOO_FAR)
        for _ in range(SWEEPS):
            after = np.minimum(costs, self._moving(costs).min(axis=0))
            if math.isclose(float(np.abs(after - costs).max()), 0.0, abs_tol=SETTLED):
                break
            costs = after
        return costs

    def _moving(self, costs: Floats) -> Floats:
        """The cost of each directive that moves: shape (3, states)."""
        by_heading = costs.reshape(TURNS, -1)
        return np.stack(
            [
                FORWARD_SECONDS + self._leads.ahead(costs),
                TURN_SECONDS + np.roll(by_heading, -1, axis=0).ravel(),
                TURN_SECONDS + np.roll(by_heading, 1, axis=0).ravel(),
            ]
        )

    def _directives(self) -> Floats:
        """The cost of each directive in each state, shape (4, states)."""
        stopping = np.where(self.goals, 0.0, STOP_BESIDE)
        return np.concatenate([self._moving(self.costs), stopping[None]])


class _Leads:
    """Where going forward leads, for averages over it; into a wall it leads nowhere."""

    def __init__(self, model: MarkovModel) -> None:
        count = len(model.locations)
        sources, targets, values = [], list[int](), list[float]()
        for heading, hops in enumerate(model.hops):
            for location, options in enumerate(hops):
                sources.append(len(targets))
                passed = {at: chance for at, chance in options.items() if at != location}
                total = sum(passed.values())
                shares = {at: chance / total for at, chance in passed.items()} or {location: 1.0}
                targets += [heading * count + at for at in shares]
                values += shares.values()
        self._begins, self._targets = np.array(sources), np.array(targets)
        self._values = np.array(values)

    def ahead(self, costs: Floats) -> Floats:
        """The mean of ``costs`` after a metre forward, for each state."""
        return np.asarray(np.add.reduceat(costs[self._targets] * self._values, self._begins))
