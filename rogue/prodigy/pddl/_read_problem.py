"""PDDL problems."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rogue.prodigy._costs import TOTAL_COST, Costs, has_value
from rogue.prodigy._domain import Domain
from rogue.prodigy._expressions import Expression, atoms
from rogue.prodigy._problem import Problem
from rogue.prodigy._reader import Word
from rogue.prodigy._state import State
from rogue.prodigy._task import Task
from rogue.prodigy._terms import Atom, Literal
from rogue.prodigy._types import Objects
from rogue.prodigy.pddl._conditions import EQUAL, Conditions
from rogue.prodigy.pddl._phrases import Phrase, parse_phrase
from rogue.prodigy.pddl._read_domain import PddlDomain, check_requirements
from rogue.prodigy.pddl._scope import Scope
from rogue.prodigy.pddl._vocabulary import Vocabulary, refuse


def read_problem(text: str, domain: PddlDomain, *, file: str = "problem") -> Task:
    """Read a problem of ``domain``.

    Raises:
        PdlError: At the first thing that is wrong or not supported, with line and column.
    """
    phrase = parse_phrase(text, file, "problem")
    check_requirements(phrase)
    _check_domain(phrase.phrases("problem_domain")[0].word(1), domain.domain)
    section = phrase.section("objects")
    objects = domain.words.with_objects(section.phrases()[0] if section else None)
    words = replace(domain.words, objects=objects)
    values: dict[Literal, float] = {}
    facts = list(_facts(phrase.phrases("init")[0], words, values))
    goal = Conditions(words).expression(phrase.phrases("goal")[0].phrases()[0], Scope())
    if _compares(domain.domain, goal):
        facts.extend(Literal(EQUAL, (name, name)) for name in objects)
    name = phrase.phrases("problem_def")[0].word(1).text
    things = Objects(domain.domain.types, objects)
    problem = Problem(domain.domain, name, things, State(facts), goal)
    return Task(problem, Costs(domain.costs, values), _minimizes(phrase))


def _check_domain(name: Word, domain: Domain) -> None:
    if name.text != domain.name:
        refuse(name, f"{domain.name}, the domain that was read", [domain.name])


def _facts(init: Phrase, words: Vocabulary, values: dict[Literal, float]) -> Iterator[Literal]:
    for element in init.phrases():
        literal = element.section("literal_name")
        if literal is None:
            yield from _value(element, words, values)
        elif isinstance(literal.parts[0], Phrase):
            yield _fact(literal.phrases()[0], words, "predicate").ground({})


def _fact(phrase: Phrase, words: Vocabulary, kind: str) -> Atom:
    name, *names = phrase.parts
    assert isinstance(name, Word)
    if name.text in words.definitions:
        refuse(name, "a predicate that is not derived")
    terms = [(word, words.object(word)) for word in names if isinstance(word, Word)]
    return words.atom(name, terms, kind=kind)


def _value(element: Phrase, words: Vocabulary, values: dict[Literal, float]) -> Iterator[Literal]:
    term, number = element.phrases()
    if term.word(0).text == TOTAL_COST:
        return
    function = _fact(term, words, "function")
    amount = float(number.word(0).text)
    if values.setdefault(function.ground({}), amount) != amount:
        refuse(term, f"one value of {function}")
    yield has_value(function).ground({})


def _compares(domain: Domain, goal: Expression) -> bool:
    expressions = [goal]
    for operator in domain.operators:
        expressions.append(operator.precondition)
        expressions.extend(effect.condition for effect in operator.effects)
    return any(atom.predicate == EQUAL for e in expressions for atom in atoms(e))


def _minimizes(phrase: Phrase) -> bool:
    metric = phrase.section("metric_spec")
    if metric is None:
        return False
    term = metric.phrases()[0].section("basic_function_term")
    if metric.word(1).text != "minimize" or term is None or term.word(0).text != TOTAL_COST:
        refuse(metric, f"(:metric minimize ({TOTAL_COST}))")
    return True
