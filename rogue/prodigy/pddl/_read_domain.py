"""PDDL domains."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from rogue.prodigy._costs import TOTAL_COST, Combined, Cost, has_value, lookups
from rogue.prodigy._domain import Domain, Effect, InferenceRule, Operator
from rogue.prodigy._expressions import And, Expression, Holds
from rogue.prodigy._functions import BUILT_IN
from rogue.prodigy._terms import Atom
from rogue.prodigy.pddl._changes import Case, Changes
from rogue.prodigy.pddl._conditions import EQUAL, Conditions, with_tests
from rogue.prodigy.pddl._derived import inference_rule, recursive
from rogue.prodigy.pddl._phrases import Phrase, parse_phrase
from rogue.prodigy.pddl._scope import Scope
from rogue.prodigy.pddl._vocabulary import (
    Definition,
    Signature,
    Vocabulary,
    refuse,
    type_tree,
)

SUPPORTED = (
    ":strips",
    ":typing",
    ":negative-preconditions",
    ":disjunctive-preconditions",
    ":existential-preconditions",
    ":universal-preconditions",
    ":quantified-preconditions",
    ":equality",
    ":conditional-effects",
    ":adl",
    ":derived-predicates",
    ":action-costs",
)


@dataclass(frozen=True, slots=True)
class PddlDomain:
    """A domain with what PDDL has beyond PRODIGY's language.

    Attributes:
        domain: Types, constants, predicates and operators.
        words: The names, as problems use them.
        costs: Cost of each action that has one.
    """

    domain: Domain
    words: Vocabulary
    costs: Mapping[str, Cost]


def read_domain(text: str, *, file: str = "domain") -> PddlDomain:
    """Read a domain.

    Raises:
        PdlError: At the first thing that is wrong or not supported, with line and column.
    """
    phrase = parse_phrase(text, file, "domain")
    check_requirements(phrase)
    words = _words(phrase)
    rules = _rules(words)
    costs: dict[str, Cost] = {}
    operators: dict[str, Operator] = {}
    for action in phrase.phrases("action_def"):
        name = action.word(1)
        if name.text in operators or name.text in {rule.name for rule in rules}:
            refuse(name, "a name that no action and no rule has yet")
        operators[name.text] = _action(action, words, costs)
    name = phrase.phrases("domain_def")[0].word(1)
    domain = Domain(
        name=name.text,
        types=words.types,
        operators=tuple(operators.values()),
        predicates=_arities(words),
        functions=dict(BUILT_IN),
        constants=dict(words.objects),
        inference_rules=rules,
    )
    return PddlDomain(domain, words, costs)


def check_requirements(phrase: Phrase) -> None:
    """Refuse the requirements of a domain or a problem that are not supported."""
    section = phrase.section("requirements")
    for at in range(1, len(section.parts) if section else 0):
        assert section is not None
        if section.word(at).text not in SUPPORTED:
            expected = "a supported requirement: " + ", ".join(SUPPORTED)
            refuse(section.word(at), expected, SUPPORTED)


def _words(phrase: Phrase) -> Vocabulary:
    words = Vocabulary(type_tree(phrase.section("types")))
    constants = phrase.section("constants")
    objects = words.with_objects(constants.phrases()[0] if constants else None)
    words = replace(words, objects=objects)
    functions = {name: s for name, s in _functions(phrase, words).items() if name != TOTAL_COST}
    words = replace(words, predicates=_predicates(phrase, words), functions=functions)
    definitions = _definitions(phrase, words)
    return replace(words, definitions=definitions, recursive=recursive(definitions))


def _predicates(phrase: Phrase, words: Vocabulary) -> dict[str, Signature]:
    section = phrase.section("predicates")
    found: dict[str, Signature] = {}
    for skeleton in section.phrases() if section else ():
        if skeleton.word(0).text in found:
            refuse(skeleton.word(0), "a predicate that is not declared twice")
        found[skeleton.word(0).text] = _signature(skeleton, words)
    return found


def _functions(phrase: Phrase, words: Vocabulary) -> dict[str, Signature]:
    section = phrase.section("functions")
    listed = section.phrases()[0].phrases() if section else ()
    return {s.word(0).text: _signature(s, words) for s in listed}


def _signature(skeleton: Phrase, words: Vocabulary) -> Signature:
    return tuple(types for _, types in words.variables(skeleton.phrases()[0]))


def _definitions(phrase: Phrase, words: Vocabulary) -> dict[str, Definition]:
    found: dict[str, Definition] = {}
    for derived in phrase.phrases("derived_predicates"):
        skeleton, condition = derived.phrases()
        name, variables = skeleton.word(0), words.variables(skeleton.phrases()[0])
        if name.text not in words.predicates:
            refuse(name, "a predicate of the domain", words.predicates)
        if len(variables) != len(words.predicates[name.text]):
            refuse(name, f"{len(words.predicates[name.text])} parameters for {name}")
        if name.text in found:
            refuse(name, "one definition of each derived predicate")
        found[name.text] = Definition(tuple(variables), condition)
    return found


def _rules(words: Vocabulary) -> tuple[InferenceRule, ...]:
    """Return the rules of derived predicates that use themselves; check the other definitions."""
    conditions = Conditions(words)
    made = {name: inference_rule(name, d, conditions) for name, d in words.definitions.items()}
    return tuple(rule for name, rule in made.items() if name in words.recursive)


def _action(action: Phrase, words: Vocabulary, costs: dict[str, Cost]) -> Operator:
    name, parameters = action.word(1), action.phrases("action_parameters")[0]
    body = action.phrases("action_body_def")[0]
    scope, variables = Scope().declare(words.variables(parameters.phrases()[0]))
    conditions = Conditions(words)
    condition, effect = body.section("emptyor_pregd"), body.section("emptyor_effect")
    needed = conditions.expression(condition, scope) if condition else And()
    made = list(Changes(conditions).of(effect, Case(scope)) if effect else ())
    effects = sorted((e for e in made if isinstance(e, Effect)), key=lambda e: e.adds)
    amounts = tuple(cost for cost in made if not isinstance(cost, Effect))
    if amounts:
        costs[name.text] = amounts[0] if len(amounts) == 1 else Combined("+", amounts)
        needed = And((needed, *_with_values(costs[name.text])))
    tested, needed = with_tests(variables, needed)
    return Operator(name.text, tuple(v.name for v in variables), tested, needed, tuple(effects))


def _with_values(cost: Cost) -> Iterator[Expression]:
    """Yield what must hold for a cost to be known: an action without a cost is none."""
    yield from (Holds(has_value(function)) for function in lookups(cost))


def _arities(words: Vocabulary) -> dict[str, int]:
    functions = {has_value(Atom(name)).predicate: len(s) for name, s in words.functions.items()}
    return {name: len(s) for name, s in words.predicates.items()} | functions | {EQUAL: 2}
