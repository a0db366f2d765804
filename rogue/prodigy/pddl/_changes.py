"""Effects and costs of actions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rogue.prodigy._costs import TOTAL_COST, Amount, Combined, Cost, Lookup
from rogue.prodigy._domain import Effect
from rogue.prodigy._expressions import TRUE, Expression, VariableSpec
from rogue.prodigy._reader import Word
from rogue.prodigy.pddl._conditions import EQUAL, Conditions
from rogue.prodigy.pddl._phrases import Phrase
from rogue.prodigy.pddl._scope import Scope
from rogue.prodigy.pddl._vocabulary import refuse

ONLY_COSTS = f"(increase ({TOTAL_COST}) ...), since functions may only be costs"


@dataclass(frozen=True, slots=True)
class Case:
    """For which values and under which condition an effect comes about."""

    scope: Scope
    variables: tuple[VariableSpec, ...] = ()
    condition: Expression = TRUE


@dataclass(frozen=True, slots=True)
class Changes:
    """Makes effects and costs of the effects of an action."""

    conditions: Conditions

    def of(self, phrase: Phrase, case: Case) -> Iterator[Effect | Cost]:
        """Yield the changes of an effect, which may be empty."""
        head = phrase.parts[0] if phrase.parts else None
        if not isinstance(head, Word):
            for part in phrase.phrases():
                yield from self._part(part, case)
            return
        match head.text:
            case "and":
                for part in phrase.phrases():
                    yield from self.of(part, case)
            case "forall":
                declared, effect = phrase.phrases()
                names = self.conditions.words.variables(declared)
                scope, variables = case.scope.declare(names)
                yield from self.of(effect, Case(scope, (*case.variables, *variables)))
            case "when":
                condition, effect = phrase.phrases()
                test = self.conditions.expression(condition, case.scope)
                yield from self.of(effect, Case(case.scope, case.variables, test))
            case "not":
                yield self._effect(phrase.phrases()[0], case, adds=False)
            case _:
                refuse(head, "an effect that is certain")

    def _part(self, phrase: Phrase, case: Case) -> Iterator[Effect | Cost]:
        if phrase.rule == "atomic_formula_term":
            yield self._effect(phrase, case, adds=True)
        elif phrase.rule == "num_effect":
            yield self._cost(phrase, case)
        else:
            yield from self.of(phrase, case)

    def _effect(self, phrase: Phrase, case: Case, *, adds: bool) -> Effect:
        words = self.conditions.words
        name, *parts = phrase.parts
        assert isinstance(name, Word)
        if name.text == EQUAL or name.text in words.definitions:
            refuse(name, "a predicate that actions may change")
        terms = [(part, words.term(part, case.scope)) for part in parts]
        atom = words.atom(name, terms, kind="predicate")
        return Effect(atom, adds, case.variables, case.condition)

    def _cost(self, phrase: Phrase, case: Case) -> Cost:
        how, target, amount = phrase.word(0), *phrase.phrases()
        if how.text != "increase" or target.word(0).text != TOTAL_COST:
            refuse(phrase, ONLY_COSTS)
        if case.variables or case.condition != TRUE:
            refuse(phrase, "a cost without forall and when")
        return self._amount(amount, case.scope)

    def _amount(self, phrase: Phrase, scope: Scope) -> Cost:
        head, inner = phrase.parts[0], phrase.phrases()
        if phrase.rule == "num_literal":
            return Amount(float(str(head)))
        if phrase.rule == "f_head":
            return self._lookup(phrase, scope)
        if isinstance(head, Phrase):
            return self._amount(head, scope)
        if head.text not in {"+", "*"}:
            refuse(head, "+ or *, since a cost is never negative")
        return Combined(head.text, tuple(self._amount(part, scope) for part in inner))

    def _lookup(self, phrase: Phrase, scope: Scope) -> Lookup:
        words = self.conditions.words
        if phrase.word(0).text == TOTAL_COST:
            refuse(phrase, "a cost that does not depend on the cost so far")
        terms = [(part, words.term(part, scope)) for part in phrase.parts[1:]]
        return Lookup(words.atom(phrase.word(0), terms, kind="function"))
