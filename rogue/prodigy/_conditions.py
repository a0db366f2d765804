"""The ``if`` of a control rule: an expression of meta-predicates."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rogue.prodigy._meta_predicates import Answer, Question
from rogue.prodigy._patterns import Pattern, RuleBindings, RuleValue
from rogue.prodigy._types import TypeSpec
from rogue.prodigy._view import SearchView

Condition = Callable[[SearchView, tuple[RuleValue, ...], RuleBindings], Iterator[RuleBindings]]
"""Yields the bindings with which it holds, given the candidates and what is bound already."""


def asked(
    meaning: Callable[[Question], Answer], arguments: tuple[Pattern | TypeSpec, ...]
) -> Condition:
    """Return the condition that one meta-predicate answers."""

    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        yield from meaning(Question(view, candidates, arguments, bindings))

    return condition


def all_of(conditions: list[Condition]) -> Condition:
    """Return the conjunction, from left to right: each is asked with what those before bound."""

    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        def rest(at: int, bound: RuleBindings) -> Iterator[RuleBindings]:
            if at == len(conditions):
                yield bound
                return
            for found in conditions[at](view, candidates, bound):
                yield from rest(at + 1, found)

        yield from rest(0, bindings)

    return condition


def any_of(conditions: list[Condition]) -> Condition:
    """Return the disjunction: what each of the conditions answers, one after the other."""

    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        for part in conditions:
            yield from part(view, candidates, bindings)

    return condition


def none_of(inner: Condition) -> Condition:
    """Return the negation: it binds nothing, and holds if ``inner`` has no answer."""

    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        if not any(True for _ in inner(view, candidates, bindings)):
            yield bindings

    return condition
