"""Parsing of types, of the objects that have them, and of types' combinations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rogue.prodigy._forms import as_list, as_word, fail, head, number, parts
from rogue.prodigy._functions import Function
from rogue.prodigy._reader import Form, Node, Word
from rogue.prodigy._types import TOP_TYPE, TypeSpec, TypeTree

COMBINATIONS = ("and", "or", "not")


def type_name(node: Node) -> str:
    """Return the name that ``node`` writes, ``:top-type`` without its colon."""
    return as_word(node, "a type").text.removeprefix(":")


def parse_types(forms: Iterable[Form], functions: Mapping[str, Function]) -> TypeTree:
    """Return the tree of types of ``(ptype-of T SUPER)`` and ``(infinite-type T #'test)``.

    Raises:
        PdlError: For a supertype that does not exist, a cycle, or an unknown test.
    """
    parents: dict[str, str] = {}
    infinite: dict[str, str] = {}
    places: list[Word] = []
    for form in forms:
        if head(form) == "ptype-of":
            name, above = (as_word(n, "a type") for n in parts(form, 2, 2, "a type and its super"))
            _declare(name, parents, infinite, type_name(above))
            parents[name.text.removeprefix(":")] = type_name(above)
            places.append(above)
        elif head(form) == "infinite-type":
            pair = parts(form, 2, 2, "a type and a function")
            name, test = (as_word(n, "a type and a function") for n in pair)
            if test.text not in functions:
                fail(test, "a registered function", functions)
            _declare(name, parents, infinite, test.text)
            infinite[name.text] = test.text
    _check_supertypes(parents, infinite, places)
    return TypeTree(parents, infinite)


def _declare(
    name: Word, parents: Mapping[str, str], infinite: Mapping[str, str], what: str
) -> None:
    before = parents.get(name.text) or infinite.get(name.text)
    if before not in {None, what}:
        fail(name, f"a type that is not also declared with {before}")
    if name.text.removeprefix(":") == TOP_TYPE:
        fail(name, "a type other than the topmost one")


def _check_supertypes(
    parents: Mapping[str, str], infinite: Mapping[str, str], places: list[Word]
) -> None:
    sound = {TOP_TYPE}
    for place in places:
        name, seen = type_name(place), list[str]()
        while name not in sound:
            if name not in parents:
                known = (TOP_TYPE, *parents, *infinite)
                fail(place, "a type that is declared with ptype-of", known)
            if name in seen:
                fail(place, "a supertype that is not its own subtype")
            seen.append(name)
            name = parents[name]
        sound.update(seen)


def parse_type_spec(node: Node, types: TypeTree) -> TypeSpec:
    """Return the types that ``T``, ``(and ..)``, ``(or ..)`` or ``(not T)`` name, nested or not.

    Raises:
        PdlError: For a type that does not exist, or a combination that no object can have.
    """
    if isinstance(node, Word):
        return TypeSpec((_known(node, types),))
    members = _members(node, types)
    if not members:
        fail(node, "a combination of types that some object can have")
    return types.spec(members)


def _known(word: Word, types: TypeTree) -> str:
    name = word.text.removeprefix(":")
    if name not in types:
        fail(word, "a type of the domain", types.names())
    return name


def _members(node: Node, types: TypeTree) -> frozenset[str]:
    if isinstance(node, Word):
        name = _known(node, types)
        return frozenset([name]) if name in types.infinite else types.members(TypeSpec((name,)))
    expected = "a type, (or TYPE ...), (not TYPE) or (and TYPE (function ...))"
    if head(node) not in COMBINATIONS:
        fail(node, expected)
    each = [_members(part, types) for part in parts(node, 1, None, expected)]
    match head(node):
        case "and":
            return frozenset.intersection(*each)
        case "or":
            return frozenset.union(*each)
    return frozenset(types.finite()) - frozenset.union(*each)


def parse_objects(nodes: Iterable[Node], types: TypeTree) -> dict[str, str]:
    """Return the type of each object of ``(a b T)``, ``(object-is a T)``, ``(objects-are a b T)``.

    Raises:
        PdlError: For an unknown type, a number, or an object with two types.
    """
    types_of: dict[str, str] = {}
    for node in nodes:
        items = as_list(node, "(object-is NAME TYPE) or (objects-are NAME ... TYPE)")
        words = [as_word(item, "a name") for item in items]
        if words and words[0].text in {"object-is", "objects-are"}:
            words = words[1:]
        if items and len(words) < 2:
            fail(node, "names of objects and their type")
        declare_objects(words[:-1], words[-1:], types, types_of)
    return types_of


def declare_objects(
    names: Iterable[Word], kinds: Iterable[Word], types: TypeTree, types_of: dict[str, str]
) -> None:
    """Put objects and their one type into ``types_of``; errors as ``parse_objects``."""
    for kind in kinds:
        known = _known(kind, types)
        if known in types.infinite:
            fail(kind, "a type that objects can have, not an infinite one", types.finite())
        for name in names:
            if number(name.text) is not None:
                fail(name, "a name, not a number")
            if types_of.setdefault(name.text, known) != known:
                fail(name, f"an object that is not also a {types_of[name.text]}")


def parse_constants(forms: Iterable[Form], types: TypeTree) -> dict[str, str]:
    """Return the type of each object of ``(pinstance-of NAME ... TYPE)``; errors as above."""
    constants: dict[str, str] = {}
    for form in forms:
        if head(form) == "pinstance-of":
            nodes = parts(form, 2, None, "objects and their type")
            *names, kind = (as_word(node, "the name of an object") for node in nodes)
            declare_objects(names, [kind], types, constants)
    return constants
