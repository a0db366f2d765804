"""Instantiated operators."""

from __future__ import annotations

from dataclasses import dataclass, field

from rogue.prodigy._domain import Operator
from rogue.prodigy._terms import Literal, Value


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """An operator with its variables bound, and one branch of its precondition.

    Attributes:
        operator: The schema.
        bindings: Values of all variables by name, angle brackets included.
        preconditions: The literals that must hold, in the order written.
        goal: What it was chosen for; None outside a search.
        node: Number of the binding node; 0 while it is only a candidate.
    """

    operator: Operator
    bindings: dict[str, Value]
    preconditions: tuple[Literal, ...]
    goal: Literal | None = None
    node: int = 0
    args: tuple[Value, ...] = field(init=False)

    def __post_init__(self) -> None:
        args = tuple(self.bindings[name] for name in self.operator.params if name in self.bindings)
        object.__setattr__(self, "args", args)

    @property
    def name(self) -> str:
        """Name of the operator."""
        return self.operator.name

    def value(self, variable: str) -> Value | None:
        """Return the value of ``variable``, given without brackets: ``value("room")``."""
        return self.bindings.get(f"<{variable}>")

    def __str__(self) -> str:
        return "<" + " ".join([self.name, *map(str, self.args)]) + ">"
