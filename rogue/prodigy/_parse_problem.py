"""Parsing of problems and of single literals."""

from __future__ import annotations

from collections.abc import Iterator

from rogue.prodigy._domain import Domain
from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._expressions import And, Expression, Holds, VariableSpec
from rogue.prodigy._forms import as_form, as_word, fail, head, number, parts
from rogue.prodigy._parse_expression import Vocabulary
from rogue.prodigy._problem import Problem
from rogue.prodigy._reader import Form, Node, Word, read
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal
from rogue.prodigy._types import Objects

SECTIONS = ("name", "objects", "state", "goal")
_NO_VARIABLES: frozenset[str] = frozenset()


def parse_problem(text: str, domain: Domain, *, file: str = "problem") -> Problem:
    """Read a problem: ``(create-problem (name ..) (objects ..) (state ..) (goal ..))``.

    Raises:
        PdlError: At the first thing that is wrong, with line and column.
    """
    sections = _sections(_problem_form(read(text, file), file))
    types_of = {**domain.constants, **_objects(sections.get("objects"), domain)}
    words = Vocabulary(domain.types, domain.functions, dict(domain.predicates), types_of, True)
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
    if len(nodes) != 1:
        raise PdlError(Position(file, 1, 1), f"{len(nodes)} expressions", "one problem")
    form = as_form(nodes[0], "(create-problem ...)")
    if head(form) == "setf":
        form = as_form(form.items[-1], "(create-problem ...)")
    if head(form) not in {"create-problem", "problem"}:
        fail(form, "(create-problem ...)", ("create-problem", "problem"))
    return form


def _sections(form: Form) -> dict[str, Form]:
    sections: dict[str, Form] = {}
    for node in form.items[1:]:
        section = as_form(node, "(name ..), (objects ..), (state ..) or (goal ..)")
        if head(section) not in SECTIONS:
            first = section.items[0] if section.items else section
            fail(first, "one of " + ", ".join(SECTIONS), SECTIONS)
        sections[head(section)] = section
    if "goal" not in sections:
        fail(form, "(goal ...) in the problem")
    return sections


def _objects(section: Form | None, domain: Domain) -> dict[str, str]:
    types_of: dict[str, str] = {}
    for node in section.items[1:] if section else ():
        form = as_form(node, "(object-is NAME TYPE) or (objects-are NAME ... TYPE)")
        words = [as_word(item, "a name") for item in form.items]
        if words and words[0].text in {"object-is", "objects-are"}:
            words = words[1:]
        if len(words) < 2:
            fail(form, "names of objects and their type")
        *names, kind = words
        if kind.text.removeprefix(":") not in domain.types:
            fail(kind, "a type of the domain", domain.types.names())
        for name in names:
            _declare(types_of, name, kind.text.removeprefix(":"))
    return types_of


def _declare(types_of: dict[str, str], name: Word, kind: str) -> None:
    if types_of.setdefault(name.text, kind) != kind:
        fail(name, f"an object that is not also a {types_of[name.text]}")
    if number(name.text) is not None:
        fail(name, "a name, not a number")


def _facts(section: Form | None, words: Vocabulary) -> Iterator[Literal]:
    for node in section.items[1:] if section else ():
        form = as_form(node, "facts in parentheses")
        listed = form.items[1:] if head(form) == "and" else (form,)
        for item in listed:
            literal = _literal(item, words)
            if not literal.positive:
                fail(item, "a fact that is true; what is not listed is false")
            yield literal


def _literal(node: Node, words: Vocabulary) -> Literal:
    form = as_form(node, "a literal in parentheses")
    if head(form) in {"~", "not"}:
        (inner,) = parts(form, 1, 1, "one literal")
        return _literal(inner, words).negated()
    return words.atom(form, _NO_VARIABLES).ground({})


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
