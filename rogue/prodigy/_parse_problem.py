"""Parsing of problems and of single literals."""

from __future__ import annotations

from collections.abc import Iterator

from rogue.prodigy._domain import Domain
from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._expressions import And, Expression, Holds, VariableSpec
from rogue.prodigy._forms import as_form, as_list, as_word, fail, first, head, parts
from rogue.prodigy._lisp import without_lisp
from rogue.prodigy._parse_expression import NEGATIONS, Vocabulary
from rogue.prodigy._parse_types import parse_objects
from rogue.prodigy._problem import Problem
from rogue.prodigy._reader import Form, Node, read
from rogue.prodigy._signatures import signatures
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal
from rogue.prodigy._types import Objects

SECTIONS = ("name", "objects", "state", "goal")
PROBLEMS = ("create-problem", "problem")
_NO_VARIABLES: frozenset[str] = frozenset()


def parse_problem(text: str, domain: Domain, *, file: str = "problem") -> Problem:
    """Read a problem: ``(create-problem (name ..) (objects ..) (state ..) (goal ..))``.

    It may stand in ``(setf (current-problem) ...)``, with other Lisp around it.

    Raises:
        PdlError: At the first thing that is wrong, with line and column.
    """
    sections = _sections(_problem_form(read(text, file), file))
    types_of = dict(domain.constants)
    if "objects" in sections:
        types_of.update(parse_objects(sections["objects"].items[1:], domain.types))
    words = Vocabulary(
        domain.types,
        domain.functions,
        dict(domain.predicates),
        types_of,
        closed=True,
        signatures=signatures(domain),
    )
    facts = tuple(_facts(sections.get("state"), words))
    variables, goal = _goal(sections["goal"], words)
    name = sections.get("name")
    title = as_word(name.items[1], "a name").text if name and len(name.items) > 1 else file
    return Problem(domain, title, Objects(domain.types, types_of), State(facts), goal, variables)


def parse_literal(text: str, domain: Domain, objects: Objects | None = None) -> Literal:
    """Read one ground literal such as ``(has-item mitchell delivermail)`` or ``(~ (p a))``.

    Raises:
        PdlError: If it is none, or does not fit the domain or the objects.
    """
    nodes = read(text, "literal")
    if len(nodes) != 1:
        raise PdlError(Position("literal", 1, 1), f"{len(nodes)} expressions", "one literal")
    known = objects.types_of if objects is not None else None
    words = Vocabulary(domain.types, domain.functions, dict(domain.predicates), known, True)
    return _literal(nodes[0], words)


def _problem_form(nodes: tuple[Node, ...], file: str) -> Form:
    found = without_lisp(map(_unwrapped, nodes), PROBLEMS)
    if not found:
        raise PdlError(Position(file, 1, 1), "no expression", "one problem")
    if len(found) > 1:
        fail(found[1], "the end of the text after one problem")
    return found[0]


def _unwrapped(node: Node) -> Node:
    """Return what ``(setf (current-problem) ...)`` sets, and other nodes as they are."""
    if isinstance(node, Form) and head(node) == "setf" and len(node.items) == 3:
        place = node.items[1]
        if isinstance(place, Form) and head(place) == "current-problem":
            return node.items[2]
    return node


def _sections(form: Form) -> dict[str, Form]:
    sections: dict[str, Form] = {}
    for node in form.items[1:]:
        section = as_form(node, "(name ..), (objects ..), (state ..) or (goal ..)")
        name = "goal" if head(section) == "igoal" else head(section)
        if name not in SECTIONS:
            fail(first(section), "one of " + ", ".join(SECTIONS), SECTIONS)
        if name in sections:
            fail(section, f"({name} ...) only once")
        sections[name] = section
    if "goal" not in sections:
        fail(form, "(goal ...) in the problem")
    return sections


def _facts(section: Form | None, words: Vocabulary) -> Iterator[Literal]:
    for node in section.items[1:] if section else ():
        items = as_list(node, "facts in parentheses")
        listed = items
        if isinstance(node, Form) and head(node):
            listed = items[1:] if head(node) == "and" else (node,)
        for item in listed:
            literal = _literal(item, words, is_fact=True)
            if not literal.positive:
                fail(item, "a fact that is true; what is not listed is false")
            yield literal


def _literal(node: Node, words: Vocabulary, *, is_fact: bool = False) -> Literal:
    form = as_form(node, "a literal in parentheses")
    if head(form) in NEGATIONS:
        (inner,) = parts(form, 1, 1, "one literal")
        return _literal(inner, words, is_fact=is_fact).negated()
    return words.atom(form, _NO_VARIABLES, is_fact=is_fact).ground({})


def _goal(section: Form, words: Vocabulary) -> tuple[tuple[VariableSpec, ...], Expression]:
    nodes = parts(section, 1, None, "a goal")
    first = as_form(nodes[0], "a goal in parentheses")
    if len(nodes) > 1 and (not first.items or isinstance(first.items[0], Form)):
        if len(nodes) > 2:
            fail(nodes[2], "the end of the goal")
        variables = words.variables(first)
        return variables, words.expression(nodes[1], frozenset(v.name for v in variables))
    goals = tuple(words.expression(node, _NO_VARIABLES) for node in nodes)
    return (), goals[0] if len(goals) == 1 and not isinstance(goals[0], Holds) else And(goals)
