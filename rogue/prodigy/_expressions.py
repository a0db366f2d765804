"""Logical expressions of preconditions and goals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rogue.prodigy._terms import Atom, Term, Variable
from rogue.prodigy._types import TypeSpec


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a registered function: ``(fn <v> <w>)`` in a variable's declaration.

    ``pattern`` is the argument of ``gen-from-pred``, whose terms are those of a literal.
    """

    function: str
    terms: tuple[Term, ...] = ()
    pattern: Atom | None = None

    def variables(self) -> tuple[str, ...]:
        """Return the names of the variables among the arguments, repeated where they repeat."""
        terms = self.pattern.terms if self.pattern else self.terms
        return tuple(term.name for term in terms if isinstance(term, Variable))


@dataclass(frozen=True, slots=True)
class VariableSpec:
    """A declared variable: its name, its types, and functions that its values must pass."""

    name: str
    types: TypeSpec
    calls: tuple[Call, ...] = ()


@dataclass(frozen=True, slots=True)
class Holds:
    """An atom that must be true."""

    atom: Atom


@dataclass(frozen=True, slots=True)
class Not:
    """The negation of an expression."""

    part: Expression


@dataclass(frozen=True, slots=True)
class And:
    """All parts hold; without parts it is true."""

    parts: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Or:
    """One part holds; without parts it is false."""

    parts: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Exists:
    """The body holds for some values of the variables."""

    variables: tuple[VariableSpec, ...]
    body: Expression


@dataclass(frozen=True, slots=True)
class Forall:
    """The body holds for all values of the variables."""

    variables: tuple[VariableSpec, ...]
    body: Expression


Expression = Holds | Not | And | Or | Exists | Forall
TRUE = And()


def atoms(expression: Expression) -> Iterator[Atom]:
    """Yield every atom of an expression, in the order written."""
    match expression:
        case Holds(atom):
            yield atom
        case Not(part) | Exists(_, part) | Forall(_, part):
            yield from atoms(part)
        case And(parts) | Or(parts):
            for part in parts:
                yield from atoms(part)


@dataclass(frozen=True, slots=True)
class Requirement:
    """An atom that must be true, or false, for an expression to be so."""

    atom: Atom
    positive: bool
    variables: frozenset[str]


def required(expression: Expression, *, positive: bool = True) -> tuple[Requirement, ...]:
    """Return what must hold whichever way an expression becomes true (or false)."""
    return tuple(_required(expression, positive=positive))


def _required(expression: Expression, *, positive: bool) -> Iterator[Requirement]:
    match expression:
        case Holds(atom):
            yield Requirement(atom, positive, frozenset(atom.variables()))
        case Not(part):
            yield from _required(part, positive=not positive)
        case And(parts) if positive:
            for part in parts:
                yield from _required(part, positive=True)
        case Or(parts) if not positive:
            for part in parts:
                yield from _required(part, positive=False)
