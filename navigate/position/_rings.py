"""What a ring of readings says of where a lost robot is, though no pose stands out.

One ring fits many places; that of the next place fits few of those that a robot can have come to
from there. So each ring weighs the cells of the belief, once for each place that it was heard at.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from navigate.body import Moved, Pose, Turned
from navigate.maps import Floats
from navigate.position._markov import Indices, MarkovModel

SAME_PLACE = 0.7
"""Metres within which a robot that moves hears much the same again."""

TEMPER = 0.25
"""Exponent of a ring's likelihood: readings err together, and virtual sensors take them in too."""

LEFT_OVER = 0.02
"""What a ring leaves for the chance to be anywhere: what is heard may be people and carts."""


class Rings:
    """Weighs beliefs by rings that were looked for; what is looked for takes some ticks.

    Meanwhile the robot may move. A cell is then weighed by how well the ring fits the cells that
    it was come to from.

    Args:
        model: states and motions.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_before", "_states", "_since", "_without", "_place")

    def __init__(self, model: MarkovModel) -> None:
        self._model = model
        self.forget()

    def forget(self) -> None:
        """Have heard none."""
        self._before: Floats = np.empty(0)
        self._states: Indices = np.empty(0, dtype=np.intp)
        self._since: list[tuple[str, int]] = []
        self._without: Floats = np.empty(0)
        self._place: Pose = (math.inf, math.inf, 0.0)

    def prior(self, chances: Floats, here: Pose) -> Floats | None:
        """The belief without the ring of the place where the robot is, in dead reckoning.

        None where that was heard on the way here, and is not to be taken out.
        """
        if math.dist(here[:2], self._place[:2]) >= SAME_PLACE:
            return chances
        return self._without if len(self._without) else None

    def ask(self, prior: Floats, states: Indices, here: Pose) -> None:
        """Begin to look for a ring that is heard ``here`` in some of the states."""
        if math.dist(here[:2], self._place[:2]) >= SAME_PLACE:
            self._without = np.empty(0)
        self._before, self._states, self._since, self._place = prior, states, [], here

    def settle(self) -> None:
        """Take what was heard at this place for good; it is looked for no more there."""
        self._without = np.empty(0)

    def report(self, report: Moved | Turned, *, looking: bool) -> None:
        """Take in a motion report; ``looking`` says that the last ring asked about is looked for.

        Only then the way is kept: a robot that is never lost drives on for days.
        """
        if isinstance(report, Moved):
            step, self._without = ("moved", report.relative), np.empty(0)
        else:
            step = ("turned", report.quarters)
            if len(self._without):
                self._without = self._model.turned(self._without, quarters=report.quarters)
        if looking:
            self._since.append(step)

    def weigh(self, chances: Floats, fits: Floats) -> Floats:
        """The belief ``chances`` by the log likelihoods of the ring in the states asked about."""
        told = np.exp(TEMPER * (fits - fits.max()))
        mass = self._before[self._states]
        likelihood = np.full(len(chances), float(told @ mass / mass.sum()))
        likelihood[self._states] = told
        weighed, before = self._before * likelihood, self._before
        for kind, number in self._since:
            weighed, before = (self._go(one, kind, number) for one in (weighed, before))
        without = self._without if len(self._without) else chances
        after = without * weighed / np.maximum(before, 1e-300)
        self._without = without
        return np.asarray((1.0 - LEFT_OVER) * after / after.sum() + LEFT_OVER / len(after))

    def _go(self, chances: Floats, kind: str, number: int) -> Floats:
        if kind == "moved":
            return self._model.moved(chances, relative=number)
        return self._model.turned(chances, quarters=number)
