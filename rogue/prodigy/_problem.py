"""Problems: objects, initial state and goal of one domain."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rogue.prodigy._domain import Domain
from rogue.prodigy._errors import LiteralError, UnknownNameError
from rogue.prodigy._expressions import And, Expression, Holds, Not, VariableSpec
from rogue.prodigy._state import State
from rogue.prodigy._terms import Atom, Literal
from rogue.prodigy._types import Objects


@dataclass(frozen=True, slots=True)
class Problem:
    """One problem of a domain.

    Attributes:
        domain: What can be done.
        name: For people.
        objects: What there is, constants of the domain included.
        state: What is true at first.
        variables: Variables of the goal.
        goal: What shall be true.
    """

    domain: Domain
    name: str
    objects: Objects
    state: State
    goal: Expression
    variables: tuple[VariableSpec, ...] = ()

    @staticmethod
    def build(
        domain: Domain,
        *,
        objects: Mapping[str, Iterable[str]],
        facts: Iterable[Literal] = (),
        goals: Iterable[Literal] = (),
        name: str = "problem",
    ) -> Problem:
        """Make a problem from values.

        Args:
            domain: What can be done.
            objects: Names of objects by type.
            facts: What is true at first.
            goals: Literals that shall all be true; may be empty, goals can be added later.
            name: For people.

        Raises:
            UnknownNameError: For a type that the domain does not have.
            LiteralError: For a fact or goal that does not fit the domain or the objects.
        """
        types_of = dict(domain.constants)
        for kind, names in objects.items():
            if kind not in domain.types:
                raise UnknownNameError("type", kind, domain.types.names())
            types_of.update(dict.fromkeys(names, kind))
        everything = Objects(domain.types, types_of)
        facts, goals = tuple(facts), tuple(goals)
        for literal in (*facts, *goals):
            check_literal(literal, domain, everything)
        return Problem(domain, name, everything, State(facts), conjunction(goals))


def conjunction(goals: Iterable[Literal]) -> Expression:
    """Return the expression that all of ``goals`` hold."""
    parts: list[Expression] = []
    for goal in goals:
        holds = Holds(Atom(goal.predicate, goal.args))
        parts.append(holds if goal.positive else Not(holds))
    return And(tuple(parts))


def check_literal(literal: Literal, domain: Domain, objects: Objects) -> None:
    """Check a literal that a program gave.

    Raises:
        LiteralError: If the number of arguments is wrong.
        UnknownNameError: If an argument is no object, or the domain has no such predicate.
    """
    arity = domain.predicates.get(literal.predicate)
    if arity is None:
        raise UnknownNameError("predicate", literal.predicate, domain.predicates)
    if arity != len(literal.args):
        raise LiteralError(literal, f"{arity} arguments")
    for value in literal.args:
        if isinstance(value, str) and value not in objects:
            raise UnknownNameError("object", value, objects.names())
