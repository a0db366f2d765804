"""The lists of the 1998 example: pending goals, applicable operators, executed operators.

Source: Haigh & Veloso (1998), section on the example, steps 1 to 9.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rogue.prodigy import (
    Announced,
    Event,
    Execute,
    Executed,
    Literal,
    NodeKind,
    Poll,
    Search,
    StepView,
)


@dataclass(frozen=True, slots=True)
class Lists:
    """What a search has to plan for, could do, and has done.

    While an operator executes it is in neither of the last two.

    Attributes:
        pending: PG: goals that are needed, false, and not worked on.
        applicable: Applicable-Ops: chosen operators whose preconditions hold.
        executed: Executed-Ops, in order.
    """

    pending: tuple[Literal, ...]
    applicable: tuple[StepView, ...]
    executed: tuple[StepView, ...]

    @staticmethod
    def of(search: Search) -> Lists:
        """The lists as they are now."""
        return Lists(
            search.pending_goals(), search.applicable_operators(), search.executed_operators()
        )

    def lines(self) -> list[str]:
        """The lists as the paper prints them."""
        applicable = list(map(_operator, self.applicable))
        executed = list(map(_operator, self.executed)) or ["nil"]
        return [
            f"PG is {_conjunction(map(str, self.pending))}",
            f"Applicable-Ops is {_conjunction(applicable)}",
            f"Executed-Ops is {executed[0]}",
            *(f"                {one}" for one in executed[1:]),
        ]


@dataclass(frozen=True, slots=True)
class Moment:
    """The lists after something happened to a node; ``node`` is 0 for goals that came."""

    node: int
    what: str
    lists: Lists


class ListWatcher:
    """Says after which events of a search its lists are other than before."""

    def __init__(self) -> None:
        self._last: Lists | None = None
        self._goals: tuple[Literal, ...] | None = None

    def observe(self, search: Search, event: Event) -> Moment | None:
        """The lists after an event of the search, if they have changed."""
        match event:
            case Announced(node=node) if node.kind is NodeKind.BINDING:
                return self._moment(search, node.number, "planned")
            case Execute(node=node):
                return self._moment(search, node.number, "executing")
            case Executed(node=node):
                return self._moment(search, node.number, "executed")
            case Poll():
                return self.goals_changed(search)
        return None

    def goals_changed(self, search: Search) -> Moment | None:
        """The lists after goals came or went, if they have changed."""
        before, self._goals = self._goals, search.goals
        if before in (None, self._goals):
            return None
        return self._moment(search, 0, "goals changed")

    def _moment(self, search: Search, node: int, what: str) -> Moment | None:
        lists = Lists.of(search)
        if lists == self._last:
            return None
        self._last = lists
        return Moment(node, what, lists)


def _operator(step: StepView) -> str:
    return f"({' '.join([step.operator.upper(), *map(str, step.args)])})"


def _conjunction(parts: Iterable[str]) -> str:
    listed: Sequence[str] = list(parts)
    if len(listed) > 1:
        return f"(and {' '.join(listed)})"
    return listed[0] if listed else "nil"
