"""Control rules as a text gives them: an ``if`` that binds variables, a ``then`` that uses them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rogue.prodigy._candidates import CandidateIndex
from rogue.prodigy._conditions import Condition
from rogue.prodigy._events import Choice
from rogue.prodigy._patterns import OneOf, Pattern, RuleBindings, plain, unify, variables
from rogue.prodigy._rules import Action, Candidate, DecideRule, PreferRule, Rule
from rogue.prodigy._view import SearchView


@dataclass(frozen=True, slots=True)
class WrittenRule(Rule):
    """A select or reject rule: it speaks of what ``wanted`` is under an answer to ``when``."""

    when: Condition
    wanted: Pattern

    def speaks_of(
        self, view: SearchView, candidates: tuple[Candidate, ...]
    ) -> tuple[Candidate, ...]:
        """Return those of the candidates that are to be selected or rejected."""
        chosen: set[int] = set()
        index = CandidateIndex(candidates)
        for bindings in _distinct(self.when(view, candidates, {}), (self.wanted,)):
            chosen.update(id(c) for c in _matched(self.wanted, index, bindings))
            if len(chosen) == len(candidates):
                break
        return tuple(c for c in candidates if id(c) in chosen)


@dataclass(frozen=True, slots=True)
class WrittenPreference(PreferRule):
    """A prefer rule: ``first`` before ``second`` under each answer to ``when``."""

    when: Condition
    first: Pattern
    second: Pattern

    def preferred(
        self, view: SearchView, current: Candidate, candidates: tuple[Candidate, ...]
    ) -> Candidate | None:
        """Return the first of the candidates that is better than ``current``, or None."""
        answers = _distinct(self.when(view, candidates, {}), (self.first, self.second))
        index = CandidateIndex(candidates)
        better: set[int] = set()
        for answer in answers:
            against = unify(self.second, current, answer)
            if against is not None:
                better.update(id(c) for c in _matched(self.first, index, against))
        return next((c for c in candidates if c is not current and id(c) in better), None)


def _matched(wanted: Pattern, index: CandidateIndex, bindings: RuleBindings) -> Iterator[Candidate]:
    for pattern in wanted.patterns if isinstance(wanted, OneOf) else (wanted,):
        for candidate in index.matching(pattern, bindings):
            if unify(pattern, candidate, bindings) is not None:
                yield candidate


def _distinct(
    answers: Iterator[RuleBindings], patterns: tuple[Pattern, ...]
) -> Iterator[RuleBindings]:
    """Yield the bindings of the patterns' variables, equal ones once."""
    names = sorted({name for pattern in patterns for name in variables(pattern)})
    seen: set[tuple[object, ...]] = set()
    for answer in answers:
        mine = {name: answer[name] for name in names if name in answer}
        key = tuple((name, plain(value)) for name, value in mine.items())
        if key not in seen:
            seen.add(key)
            yield mine


def written_rule(
    name: str, choice: Choice, action: Action, when: Condition, wanted: Pattern
) -> WrittenRule:
    """Return a select or reject rule."""

    def test(view: SearchView, candidate: Candidate, among: tuple[Candidate, ...]) -> bool:
        return any(c is candidate for c in rule.speaks_of(view, among))

    rule = WrittenRule(name, choice, action, test, when, wanted)
    return rule


def written_preference(
    name: str, choice: Choice, when: Condition, first: Pattern, second: Pattern
) -> WrittenPreference:
    """Return a rule that prefers ``first`` to ``second``."""

    def better(view: SearchView, one: Candidate, other: Candidate) -> bool:
        return rule.preferred(view, other, (one, other)) is one

    rule = WrittenPreference(name, choice, better, when, first, second)
    return rule


def written_decision(name: str, action: Action, when: Condition) -> DecideRule:
    """Return a rule between sub-goaling and applying."""
    return DecideRule(name, action, lambda view: any(True for _ in when(view, (), {})))
