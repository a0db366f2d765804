"""What control rules may see of a running search."""

from __future__ import annotations

from typing import Protocol

from rogue.prodigy._domain import Operator
from rogue.prodigy._instance import Instance
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal
from rogue.prodigy._types import Objects


class SearchView(Protocol):
    """A search as control rules see it: read only, at the node being expanded."""

    @property
    def state(self) -> State:
        """The simulated world."""

    @property
    def objects(self) -> Objects:
        """What there is."""

    @property
    def goal(self) -> Literal | None:
        """The goal for which an operator or bindings are being chosen; None elsewhere."""

    @property
    def operator(self) -> Operator | None:
        """The operator for which bindings are being chosen; None elsewhere."""

    def consumers(self, goal: Literal) -> tuple[Instance, ...]:
        """Return the live, not yet applied operators that need ``goal``."""

    def lacking(self, instance: Instance) -> tuple[Literal, ...]:
        """Return the preconditions of ``instance`` that are false now."""

    def top_level_goals(self, candidate: Literal | Instance) -> tuple[Literal, ...]:
        """Return the goals of the problem that ``candidate`` serves in the end."""

    def pending_goals(self) -> tuple[Literal, ...]:
        """Return the goals needed, false and not yet worked on, before any rule."""

    def ready(self) -> tuple[Instance, ...]:
        """Return the operators that could be applied, newest first, before any rule."""

    def expanded_goals(self) -> tuple[Literal, ...]:
        """Return the goals being worked on, oldest first."""

    def goals(self) -> tuple[Literal, ...]:
        """Return the goals of the problem now."""

    def objects_of(self, kind: str) -> tuple[str, ...]:
        """Return the objects of a type, in the order of their declaration."""

    def tail(self) -> tuple[Instance, ...]:
        """Return the chosen and not yet applied operators of this path, oldest first."""
