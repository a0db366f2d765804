"""Values, variables, patterns and ground literals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

Value = str | int | float
"""What an argument of a literal can be: an object's name, or a number of an infinite type."""


class Literal(NamedTuple):
    """A ground fact or its negation, such as ``Literal("robot-in-room", ("r-5303",))``.

    Names are in lower case, as the reader makes them.
    """

    predicate: str
    args: tuple[Value, ...] = ()
    positive: bool = True

    def negated(self) -> Literal:
        """Return the literal that is true exactly when this one is false."""
        return Literal(self.predicate, self.args, not self.positive)

    def __str__(self) -> str:
        text = "(" + " ".join([self.predicate, *map(str, self.args)]) + ")"
        return text if self.positive else f"not {text}"


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of an operator, a goal or a rule; the name keeps its angle brackets."""

    name: str

    def __str__(self) -> str:
        return self.name


Term = Variable | Value
Bindings = Mapping[str, Value]
"""Values of variables by name, angle brackets included."""


@dataclass(frozen=True, slots=True)
class Atom:
    """A predicate over terms: a literal's pattern, without sign."""

    predicate: str
    terms: tuple[Term, ...] = ()

    def variables(self) -> Iterator[str]:
        """Yield the names of the variables, in order, repeated where they repeat."""
        return (term.name for term in self.terms if isinstance(term, Variable))

    def ground(self, bindings: Bindings, *, positive: bool = True) -> Literal:
        """Return the literal under ``bindings``; KeyError names an unbound variable."""
        args = tuple(
            bindings[term.name] if isinstance(term, Variable) else term for term in self.terms
        )
        return Literal(self.predicate, args, positive)

    def pattern(self, bindings: Bindings) -> tuple[Value | None, ...]:
        """Return the terms' values, None for variables that have none."""
        return tuple(
            bindings.get(term.name) if isinstance(term, Variable) else term for term in self.terms
        )

    def match(self, args: tuple[Value, ...], bindings: Bindings) -> dict[str, Value] | None:
        """Return ``bindings`` extended so that the terms equal ``args``, or None."""
        if len(args) != len(self.terms):
            return None
        found = dict(bindings)
        for term, value in zip(self.terms, args, strict=True):
            if isinstance(term, Variable):
                if found.setdefault(term.name, value) != value:
                    return None
            elif term != value:
                return None
        return found

    def __str__(self) -> str:
        return "(" + " ".join([self.predicate, *map(str, self.terms)]) + ")"
