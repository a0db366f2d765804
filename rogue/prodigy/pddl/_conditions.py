"""Conditions of actions, effects and goals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from rogue.prodigy._expressions import (
    And,
    Call,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
)
from rogue.prodigy._reader import Word
from rogue.prodigy._terms import Atom, Variable
from rogue.prodigy.pddl._phrases import Part, Phrase
from rogue.prodigy.pddl._scope import Scope, Typed
from rogue.prodigy.pddl._vocabulary import Vocabulary, refuse

EQUAL = "="
"""A static predicate: true of every object and itself."""
MOST_REPLACED = 1000
"""Uses of derived predicates in a file, those within others counted each time."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """Makes expressions of conditions.

    A derived predicate is replaced by what it stands for, so that the search can work for its
    parts, and against them where its negation is wanted. One that uses itself stays: a rule says
    where it holds.

    Attributes:
        words: What a condition may name.
        replaced: Names of all derived predicates that were replaced.
    """

    words: Vocabulary
    replaced: list[str] = field(default_factory=list)

    def expression(self, phrase: Phrase, scope: Scope) -> Expression:
        """Return the expression of a condition, which may be empty."""
        if not phrase.parts:
            return And()
        head = phrase.parts[0]
        if isinstance(head, Phrase):
            nested = head.rule in {"gd", "emptyor_pregd"}
            return self.expression(head, scope) if nested else self._atomic(head, scope)
        inner = [part for part in phrase.parts[1:] if isinstance(part, Phrase)]
        match head.text:
            case "and":
                return And(tuple(self.expression(part, scope) for part in inner))
            case "or":
                return Or(tuple(self.expression(part, scope) for part in inner))
            case "not":
                return Not(self.expression(inner[0], scope))
            case "imply":
                first, then = (self.expression(part, scope) for part in inner)
                return Or((Not(first), then))
            case _:
                return self._quantified(phrase, scope)

    def _quantified(self, phrase: Phrase, scope: Scope) -> Expression:
        if phrase.word(0).text not in {"exists", "forall"}:
            refuse(phrase, "a condition without numbers: functions may only be costs")
        declared, body = phrase.phrases()
        inner, variables = scope.declare(self.words.variables(declared))
        kind = Exists if phrase.word(0).text == "exists" else Forall
        return kind(variables, self.expression(body, inner))

    def _atomic(self, phrase: Phrase, scope: Scope) -> Expression:
        name, *parts = phrase.parts
        assert isinstance(name, Word)
        terms = [(part, self.words.term(part, scope)) for part in parts]
        if name.text == EQUAL:
            return Holds(Atom(EQUAL, tuple(typed.term for _, typed in terms)))
        atom = self.words.atom(name, terms, kind="predicate")
        if name.text not in self.words.definitions or name.text in self.words.recursive:
            return Holds(atom)
        return self._derived(name, terms, scope)

    def _derived(self, name: Word, terms: list[tuple[Part, Typed]], scope: Scope) -> Expression:
        self.replaced.append(name.text)
        if len(self.replaced) > MOST_REPLACED:
            refuse(name, f"at most {MOST_REPLACED} uses of derived predicates, within others too")
        definition = self.words.definitions[name.text]
        names: dict[str, Typed] = {}
        for (part, typed), (word, types) in zip(terms, definition.parameters, strict=True):
            if not self.words.must_be(typed.types, types):
                refuse(part, f"a {types} for {name}", found=f"a {typed.types}")
            names[word.text] = typed
        return self.expression(definition.condition, scope.binding(names))


def with_tests(
    variables: tuple[VariableSpec, ...], condition: Expression
) -> tuple[tuple[VariableSpec, ...], Expression]:
    """Turn each (in)equality that must hold into a test of the later of its variables.

    So values that do not fit are left out as soon as they are known, and no alternatives are
    made of them.
    """
    order = {spec.name: at for at, spec in enumerate(variables)}
    calls: dict[str, list[Call]] = {name: [] for name in order}
    kept: list[Expression] = []
    for part in _conjuncts(condition):
        call = _test(part)
        names = [t.name for t in call.terms if isinstance(t, Variable)] if call else []
        if call and names and all(name in order for name in names):
            calls[max(names, key=order.__getitem__)].append(call)
        else:
            kept.append(part)
    tested = tuple(replace(spec, calls=tuple(calls[spec.name])) for spec in variables)
    return tested, kept[0] if len(kept) == 1 else And(tuple(kept))


def _conjuncts(condition: Expression) -> Iterator[Expression]:
    if isinstance(condition, And):
        for part in condition.parts:
            yield from _conjuncts(part)
    else:
        yield condition


def _test(part: Expression) -> Call | None:
    match part:
        case Holds(Atom(predicate=predicate, terms=terms)) if predicate == EQUAL:
            return Call("same", terms)
        case Not(Holds(Atom(predicate=predicate, terms=terms))) if predicate == EQUAL:
            return Call("diff", terms)
    return None
