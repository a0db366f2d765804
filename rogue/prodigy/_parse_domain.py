"""Parsing of domains."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rogue.prodigy._domain import Domain, Effect, Function, Operator
from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._expressions import TRUE, And, Expression, VariableSpec, atoms
from rogue.prodigy._forms import as_form, as_word, fail, head, is_variable, parts
from rogue.prodigy._functions import BUILT_IN
from rogue.prodigy._meta_predicates import MetaPredicate
from rogue.prodigy._parse_expression import Scope, Vocabulary
from rogue.prodigy._parse_rules import parse_rules
from rogue.prodigy._reader import Form, Node, Word, read
from rogue.prodigy._terms import Atom
from rogue.prodigy._types import TOP_TYPE, TypeTree

SECTIONS = (
    "create-problem-space",
    "ptype-of",
    "infinite-type",
    "pinstance-of",
    "operator",
    "control-rule",
)


def parse_domain(
    text: str,
    *,
    file: str = "domain",
    functions: Mapping[str, Function] | None = None,
    meta_predicates: Mapping[str, MetaPredicate] | None = None,
) -> Domain:
    """Read a domain from PRODIGY's language.

    Args:
        text: The domain.
        file: Its name in errors.
        functions: Functions that variables' types may call, by name.
        meta_predicates: Meta-predicates of control rules besides PRODIGY's own, by name.

    Raises:
        PdlError: At the first thing that is wrong, with line and column.
    """
    forms = [as_form(node, "'('") for node in read(text, file)]
    if not forms:
        raise PdlError(Position(file, 1, 1), "no expression", "a domain with its operators")
    for form in forms:
        if head(form) not in SECTIONS:
            fail(form.items[0] if form.items else form, "one of " + ", ".join(SECTIONS), SECTIONS)
    known = {**BUILT_IN, **{name.lower(): f for name, f in (functions or {}).items()}}
    words = Vocabulary(_types(forms, known), known)
    constants = _constants(forms, words)
    operators = _operators(forms, words)
    rules = parse_rules(
        [f for f in forms if head(f) == "control-rule"], operators, meta_predicates or {}
    )
    name = _name(forms) or file
    return Domain(name, words.types, operators, words.predicates, known, constants, rules)


def _name(forms: list[Form]) -> str:
    spaces = [f for f in forms if head(f) == "create-problem-space"]
    return as_word(spaces[0].items[1], "a name").text if spaces and spaces[0].items[1:] else ""


def _types(forms: list[Form], functions: Mapping[str, Function]) -> TypeTree:
    parents: dict[str, str] = {}
    infinite: dict[str, str] = {}
    places: list[Word] = []
    for form in forms:
        if head(form) == "ptype-of":
            name, above = (as_word(n, "a type") for n in parts(form, 2, 2, "a type and its super"))
            parents[name.text] = above.text.removeprefix(":")
            places.append(above)
        elif head(form) == "infinite-type":
            pair = parts(form, 2, 2, "a type and a function")
            name, test = (as_word(n, "a type and a function") for n in pair)
            if test.text not in functions:
                fail(test, "a registered function", functions)
            infinite[name.text] = test.text
    _check_types(parents, infinite, places)
    return TypeTree(parents, infinite)


def _check_types(parents: dict[str, str], infinite: dict[str, str], places: list[Word]) -> None:
    for place in places:
        name = place.text.removeprefix(":")
        seen = {name}
        while name != TOP_TYPE:
            if name not in parents:
                known = (TOP_TYPE, *parents, *infinite)
                fail(place, "a type that is declared with ptype-of", known)
            name = parents[name]
            if name in seen:
                fail(place, "a supertype that is not its own subtype")
            seen.add(name)


def _constants(forms: list[Form], words: Vocabulary) -> dict[str, str]:
    constants: dict[str, str] = {}
    for form in forms:
        if head(form) == "pinstance-of":
            *names, kind = parts(form, 2, None, "objects and their type")
            spec = words.type_spec(kind)
            for name in names:
                constants[as_word(name, "the name of an object").text] = spec.names[0]
    return constants


def _operators(forms: list[Form], words: Vocabulary) -> tuple[Operator, ...]:
    operators: dict[str, Operator] = {}
    for form in forms:
        if head(form) == "operator":
            if len(form.items) < 2:
                fail(form, "the name of the operator")
            name = as_word(form.items[1], "the name of the operator")
            if name.text in operators:
                fail(name, "a name that no operator has yet")
            operators[name.text] = _operator(form, name.text, words)
    return tuple(operators.values())


def _operator(form: Form, name: str, words: Vocabulary) -> Operator:
    sections: dict[str, Form] = {}
    allowed = ("params", "preconds", "effects")
    for node in form.items[2:]:
        section = as_form(node, "(params ...), (preconds ...) or (effects ...)")
        if head(section) not in allowed:
            fail(section, "params, preconds or effects", allowed)
        sections[head(section)] = section
    for needed in ("preconds", "effects"):
        if needed not in sections:
            fail(form, f"({needed} ...) in operator {name}")
    variables, precondition = _preconds(sections["preconds"], words)
    scope = frozenset(v.name for v in variables)
    effects = _effects(sections["effects"], words, scope)
    params = _params(sections.get("params"), scope)
    return Operator(name, params, variables, precondition, effects)


def _params(section: Form | None, scope: Scope) -> tuple[str, ...]:
    names: list[str] = []
    for node in section.items[1:] if section else ():
        if not is_variable(node) or as_word(node, "a variable").text not in scope:
            fail(node, "a variable declared in preconds", scope)
        names.append(as_word(node, "a variable").text)
    return tuple(names)


def _preconds(section: Form, words: Vocabulary) -> tuple[tuple[VariableSpec, ...], Expression]:
    nodes = parts(section, 1, 2, "variables and one expression")
    variables = words.variables(nodes[0])
    scope = frozenset(v.name for v in variables)
    return variables, words.expression(nodes[1], scope) if len(nodes) > 1 else TRUE


def _effects(section: Form, words: Vocabulary, scope: Scope) -> tuple[Effect, ...]:
    declared, changes = parts(section, 2, 2, "variables and a list of effects")
    locals_ = words.variables(declared, scope)
    effects = list(_changes(changes, words, scope, locals_, TRUE))
    return tuple(sorted(effects, key=lambda effect: effect.adds))


def _changes(
    node: Node,
    words: Vocabulary,
    scope: Scope,
    locals_: tuple[VariableSpec, ...],
    condition: Expression,
) -> Iterator[Effect]:
    inner = scope | {v.name for v in locals_}
    for item in as_form(node, "a list of effects").items:
        form = as_form(item, "(add ...), (del ...), (if ...) or (forall ...)")
        match head(form):
            case "add" | "del" as kind:
                (atom,) = (words.atom(n, inner) for n in parts(form, 1, 1, "one literal"))
                yield _effect(atom, locals_, condition, adds=kind == "add")
            case "if":
                test, then = parts(form, 2, 2, "a condition and a list of effects")
                both = And((condition, words.expression(test, inner)))
                yield from _changes(then, words, scope, locals_, both)
            case "forall":
                expected = "variables, a condition and a list of effects"
                more, test, then = parts(form, 3, 3, expected)
                wider = (*locals_, *words.variables(more, inner))
                names = scope | {v.name for v in wider}
                both = And((condition, words.expression(test, names)))
                yield from _changes(then, words, scope, wider, both)
            case _:
                fail(form, "add, del, if or forall", ("add", "del", "if", "forall"))


def _effect(
    atom: Atom, locals_: tuple[VariableSpec, ...], condition: Expression, *, adds: bool
) -> Effect:
    used = set(atom.variables())
    used.update(name for a in atoms(condition) for name in a.variables())
    return Effect(atom, adds, tuple(v for v in locals_ if v.name in used), condition)
