"""Which plans of a search for several solutions count."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rogue.prodigy._options import SearchOptions, Solutions
from rogue.prodigy._terms import Value

if TYPE_CHECKING:
    from rogue.prodigy._events import StepView
    from rogue.prodigy._nodes import Node

_BETTER = {Solutions.SHORTER, Solutions.CHEAPER}
_Key = tuple[tuple[str, tuple[tuple[str, Value], ...]], ...]


class SolutionFilter:
    """Remembers what was found.

    Attributes:
        count: How many plans were accepted.
        last: The last of them.
    """

    def __init__(self, options: SearchOptions) -> None:
        self._wanted = options.solutions
        self._step_cost = options.step_cost
        self._seen: set[_Key] = set()
        self._best = math.inf
        self.count = 0
        self.last: tuple[StepView, ...] = ()

    @property
    def held(self) -> int:
        """How many plans are remembered."""
        return len(self._seen)

    def accepts(self, plan: tuple[StepView, ...]) -> bool:
        """Say whether a plan is one that is wanted; it is remembered then."""
        if self._wanted is Solutions.DIFFERENT:
            key = tuple((step.operator, step.bindings) for step in plan)
            if key in self._seen:
                return False
            self._seen.add(key)
        if self._wanted in _BETTER:
            measure = math.fsum(map(self._measure, plan))
            if measure >= self._best:
                return False
            self._best = measure
        self.count += 1
        self.last = plan
        return True

    def is_too_long(self, node: Node) -> bool:
        """Say whether no plan through ``node``, which is not the end of one, can be wanted."""
        if self._wanted not in _BETTER or not self.count:
            return False
        if self._wanted is Solutions.SHORTER:
            return node.steps + 1 >= self._best
        return self._cost(node) >= self._best

    def _measure(self, step: StepView) -> float:
        if self._wanted is Solutions.SHORTER or self._step_cost is None:
            return 1.0
        return self._step_cost(step)

    def _cost(self, node: Node) -> float:
        """Return what the steps down to ``node`` cost; every node remembers it."""
        path: list[Node] = []
        above: Node | None = node
        while above is not None and above.cost is None:
            path.append(above)
            above = above.parent
        cost = 0.0 if above is None or above.cost is None else above.cost
        for below in reversed(path):
            cost += self._measure(below.step()) if below.is_step() else 0.0
            below.cost = cost
        return cost
