"""Derived predicates: which of them use themselves, and the rules that those become."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rogue.prodigy._domain import Effect, InferenceRule
from rogue.prodigy._reader import Word
from rogue.prodigy._terms import Atom, Variable
from rogue.prodigy.pddl._conditions import Conditions
from rogue.prodigy.pddl._phrases import Phrase
from rogue.prodigy.pddl._scope import Scope
from rogue.prodigy.pddl._vocabulary import Definition, refuse

Use = tuple[Word, bool]
"""A predicate that a definition uses, and whether it wants it false."""


def recursive(definitions: Mapping[str, Definition]) -> frozenset[str]:
    """Return the names of the derived predicates that use themselves, directly or not.

    Raises:
        PdlError: If one uses its own negation, so that it means nothing.
    """
    used = {name: list(_uses(d.condition)) for name, d in definitions.items()}
    reach = {name: _reach(name, used) for name in used}
    for name, uses in used.items():
        for word, is_negative in uses:
            if is_negative and name in reach.get(word.text, ()):
                refuse(word, f"a definition of {name} that does not use its own negation")
    return frozenset(name for name in used if name in reach[name])


def _reach(name: str, used: Mapping[str, list[Use]]) -> set[str]:
    found: set[str] = set()
    agenda = [name]
    while agenda:
        for word, _ in used.get(agenda.pop(), ()):
            if word.text not in found:
                found.add(word.text)
                agenda.append(word.text)
    return found


def _uses(phrase: Phrase, *, is_negative: bool = False) -> Iterator[Use]:
    head, inner = phrase.parts[0] if phrase.parts else None, phrase.phrases()
    if phrase.rule == "atomic_formula_term":
        yield phrase.word(0), is_negative
        return
    turns = isinstance(head, Word) and head.text in {"not", "imply"}
    for at, part in enumerate(inner):
        yield from _uses(part, is_negative=is_negative != (turns and at == 0))


def inference_rule(name: str, definition: Definition, conditions: Conditions) -> InferenceRule:
    """Return the lazy rule that says what a derived predicate says."""
    scope, variables = Scope().declare(definition.parameters)
    atom = Atom(name, tuple(Variable(spec.name) for spec in variables))
    return InferenceRule(
        name=f"derive-{name}",
        params=tuple(spec.name for spec in variables),
        variables=variables,
        precondition=conditions.expression(definition.condition, scope),
        effects=(Effect(atom, adds=True),),
    )
