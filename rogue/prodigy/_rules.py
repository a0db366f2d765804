"""Control rules: who may say which candidate is taken.

A rule is a plain function with a name. Rules of a choice run in this order: of the select rules
the first that matches any candidate replaces the candidates by those; then every reject rule
removes candidates; then prefer rules lead from the first candidate to a better one. "First" is
the newest definition: the last in the tuple. What remains is decided by PRODIGY's defaults.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from rogue.prodigy._domain import Operator
from rogue.prodigy._events import Choice, NodeView
from rogue.prodigy._instance import Instance
from rogue.prodigy._terms import Literal
from rogue.prodigy._view import SearchView


class Action(StrEnum):
    """What a rule does to the candidates for which its test holds."""

    SELECT = "select"
    REJECT = "reject"
    SUB_GOAL = "sub-goal"
    APPLY = "apply"
    PROTECT = "protect"
    PREFER = "prefer"


Candidate = Literal | Operator | Instance | NodeView
"""A literal for goals, an operator for operators, an instance for bindings and applied-op.

A choice of node has views of the open nodes.
"""

Test = Callable[[SearchView, Candidate, tuple[Candidate, ...]], bool]
"""Called with the search, one candidate, and all candidates that are left."""


@dataclass(frozen=True, slots=True)
class Rule:
    """A select or reject rule over one kind of choice.

    Attributes:
        name: Shown in traces and decisions.
        choice: Goal, operator, bindings, applied-op or node.
        action: SELECT or REJECT.
        test: Whether the rule speaks of this candidate.
    """

    name: str
    choice: Choice
    action: Action
    test: Test

    def speaks_of(
        self, view: SearchView, candidates: tuple[Candidate, ...]
    ) -> tuple[Candidate, ...]:
        """Return those of the candidates that are to be selected or rejected."""
        return tuple(c for c in candidates if self.test(view, c, candidates))


@dataclass(frozen=True, slots=True)
class PreferRule:
    """A rule that prefers one candidate to another: ``better(search, a, b)``: a before b."""

    name: str
    choice: Choice
    better: Callable[[SearchView, Candidate, Candidate], bool]

    def preferred(
        self, view: SearchView, current: Candidate, candidates: tuple[Candidate, ...]
    ) -> Candidate | None:
        """Return the first of the candidates that is better than ``current``, or None."""
        others = (c for c in candidates if c is not current)
        return next((c for c in others if self.better(view, c, current)), None)


@dataclass(frozen=True, slots=True)
class DecideRule:
    """A rule between sub-goaling and applying, asked when both are possible.

    One that says PROTECT is asked wherever an operator can be applied: if its effects would undo
    what others need, the conditions of those effects are made false first.
    """

    name: str
    action: Action
    test: Callable[[SearchView], bool]


@dataclass(frozen=True, slots=True)
class RuleSet:
    """Control rules in order of definition; the newest, last, is asked first.

    ``a + b`` has b's rules defined after a's.
    """

    rules: tuple[Rule | PreferRule | DecideRule, ...] = ()

    def __add__(self, other: RuleSet) -> RuleSet:
        return RuleSet(self.rules + other.rules)
