"""Parsing of domains."""

from __future__ import annotations

from collections.abc import Mapping

from rogue.prodigy._domain import Domain, Function
from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._forms import as_form, as_word, fail, head, parts
from rogue.prodigy._functions import BUILT_IN
from rogue.prodigy._meta_predicates import MetaPredicate
from rogue.prodigy._parse_expression import Vocabulary
from rogue.prodigy._parse_operators import parse_operators
from rogue.prodigy._parse_rules import parse_rules
from rogue.prodigy._reader import Form, Word, read
from rogue.prodigy._types import TOP_TYPE, TypeTree

SECTIONS = (
    "create-problem-space",
    "ptype-of",
    "infinite-type",
    "pinstance-of",
    "operator",
    "inference-rule",
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
    operators, inference_rules = parse_operators(forms, words)
    rules = parse_rules(
        [f for f in forms if head(f) == "control-rule"],
        (*operators, *inference_rules),
        meta_predicates or {},
    )
    name = _name(forms) or file
    return Domain(
        name, words.types, operators, words.predicates, known, constants, rules, inference_rules
    )


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
