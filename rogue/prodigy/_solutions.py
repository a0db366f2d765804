"""Which plans of a search for several solutions count."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rogue.prodigy._options import Solutions
from rogue.prodigy._terms import Value

if TYPE_CHECKING:
    from rogue.prodigy._events import StepView
    from rogue.prodigy._nodes import Node

_Key = tuple[tuple[str, tuple[tuple[str, Value], ...]], ...]


class SolutionFilter:
    """Remembers what was found.

    Attributes:
        count: How many plans were accepted.
        last: The last of them.
    """

    def __init__(self, wanted: Solutions) -> None:
        self._wanted = wanted
        self._seen: set[_Key] = set()
        self.count = 0
        self.last: tuple[StepView, ...] = ()

    @property
    def held(self) -> int:
        """How many plans are remembered."""
        return len(self._seen)

    def accepts(self, plan: tuple[StepView, ...]) -> bool:
        """Say whether a plan is one that is wanted; it is remembered then."""
        if self._wanted is Solutions.SHORTER and self.count and len(plan) >= len(self.last):
            return False
        if self._wanted is Solutions.DIFFERENT:
            key = tuple((step.operator, step.bindings) for step in plan)
            if key in self._seen:
                return False
            self._seen.add(key)
        self.count += 1
        self.last = plan
        return True

    def is_too_long(self, node: Node) -> bool:
        """Say whether no plan through ``node``, which is not the end of one, can be wanted."""
        if self._wanted is not Solutions.SHORTER or not self.count:
            return False
        return node.steps + 1 >= len(self.last)
