"""What a PDDL domain names: types, objects, predicates, functions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NoReturn

from rogue.prodigy._errors import PdlError
from rogue.prodigy._reader import Word
from rogue.prodigy._terms import Atom
from rogue.prodigy._types import TOP_TYPE, TypeSpec, TypeTree
from rogue.prodigy.pddl._phrases import Part, Phrase
from rogue.prodigy.pddl._scope import Scope, Typed

ANY = TypeSpec()
OBJECT = "object"
"""PDDL's name of the type above all others."""

Signature = tuple[TypeSpec, ...]


def refuse(part: Part, expected: str, known: Iterable[str] = (), found: str = "") -> NoReturn:
    """Raise the PdlError that something else was expected where ``part`` stands."""
    raise PdlError(part.position, found or str(part), expected, known)


@dataclass(frozen=True, slots=True)
class Definition:
    """What a derived predicate stands for: a condition over its parameters."""

    parameters: tuple[tuple[Word, TypeSpec], ...]
    condition: Phrase


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """The names that a text may use, with their types.

    Attributes:
        types: The domain's types below ``top-type``, which is PDDL's ``object``.
        objects: Types of the domain's constants and of a problem's objects.
        predicates: Types of the arguments of each predicate, derived ones among them.
        functions: The same of each function.
        definitions: What derived predicates stand for.
        recursive: Those of them that use themselves.
    """

    types: TypeTree
    objects: Mapping[str, str] = field(default_factory=dict)
    predicates: Mapping[str, Signature] = field(default_factory=dict)
    functions: Mapping[str, Signature] = field(default_factory=dict)
    definitions: Mapping[str, Definition] = field(default_factory=dict)
    recursive: frozenset[str] = frozenset()

    def type_named(self, word: Word) -> str:
        """Return the type that ``word`` names."""
        if word.text == OBJECT:
            return TOP_TYPE
        if word.text not in self.types:
            refuse(word, "a type of the domain", (OBJECT, *self.types.parents))
        return word.text

    def variables(self, phrase: Phrase) -> list[tuple[Word, TypeSpec]]:
        """Return the variables of a typed list with their types."""
        found = [(w, self._types(kind)) for w, kind in typed_list(phrase)]
        for at, (word, _) in enumerate(found):
            if word.text in {earlier.text for earlier, _ in found[:at]}:
                refuse(word, "a variable that is not declared twice", found=f"?{word}")
        return found

    def _types(self, kind: Part | None) -> TypeSpec:
        if kind is None:
            return ANY
        words = kind.parts if isinstance(kind, Phrase) else (kind,)
        names = (w for w in words if isinstance(w, Word) and w.text != "either")
        return TypeSpec(tuple(self.type_named(w) for w in names))

    def with_objects(self, phrase: Phrase | None) -> dict[str, str]:
        """Return the types of the objects so far and of those that a typed list adds."""
        objects = dict(self.objects)
        for word, kind in typed_list(phrase) if phrase else ():
            name = self.type_named(kind) if isinstance(kind, Word) else TOP_TYPE
            if objects.setdefault(word.text, name) != name:
                refuse(word, f"an object that is not also a {objects[word.text]}")
        return objects

    def term(self, part: Part, scope: Scope) -> Typed:
        """Return what a variable or a constant stands for."""
        if isinstance(part, Word):
            if part.text not in scope.names:
                known = (f"?{name}" for name in scope.names)
                refuse(part, "a variable that is declared", known, f"?{part}")
            return scope.names[part.text]
        return self.object(part.word(0))

    def object(self, word: Word) -> Typed:
        """Return a constant of the domain or an object of the problem."""
        if word.text not in self.objects:
            refuse(word, "an object or a constant", self.objects)
        return Typed(word.text, TypeSpec((self.objects[word.text],)))

    def atom(self, name: Word, terms: Iterable[tuple[Part, Typed]], *, kind: str) -> Atom:
        """Return an atom whose terms have been checked.

        Args:
            name: Of the predicate or function.
            terms: The terms, with the places to name in an error.
            kind: "predicate" or "function".
        """
        table = self.predicates if kind == "predicate" else self.functions
        if name.text not in table:
            refuse(name, f"a {kind} of the domain", table)
        signature, found = table[name.text], tuple(terms)
        if len(found) != len(signature):
            expected = f"{len(signature)} arguments for {name}"
            refuse(name, expected, found=f"{name} with {len(found)} arguments")
        for (part, typed), types in zip(found, signature, strict=True):
            if not self.may_be(typed.types, types):
                shown = part.word(0) if isinstance(part, Phrase) else part
                refuse(part, f"a {types} for {name}", found=f"{shown}, which is a {typed.types}")
        return Atom(name.text, tuple(typed.term for _, typed in found))

    def may_be(self, types: TypeSpec, other: TypeSpec) -> bool:
        """Say whether something can be of both."""
        is_a = self.types.is_a
        return any(is_a(a, b) or is_a(b, a) for a in types.names for b in other.names)

    def must_be(self, types: TypeSpec, other: TypeSpec) -> bool:
        """Say whether all that is of ``types`` is of ``other``."""
        return all(any(self.types.is_a(a, b) for b in other.names) for a in types.names)


def typed_list(phrase: Phrase) -> Iterator[tuple[Word, Part | None]]:
    """Yield the names of ``a b - t c`` with their types; None where none is given."""
    waiting: list[Word] = []
    parts = iter(phrase.parts)
    for part in parts:
        if isinstance(part, Word) and part.text == "-":
            kind = next(parts)
            yield from ((word, kind) for word in waiting)
            waiting = []
        else:
            assert isinstance(part, Word)
            waiting.append(part)
    yield from ((word, None) for word in waiting)


def type_tree(phrase: Phrase | None) -> TypeTree:
    """Return the types of ``(:types ...)``; a supertype need not be declared itself.

    Raises:
        PdlError: For a type with two supertypes, or one below itself.
    """
    parents: dict[str, str] = {}
    section = phrase.section("typed_list_name") if phrase else None
    for word, kind in typed_list(section) if section else ():
        above = kind.text if isinstance(kind, Word) and kind.text != OBJECT else TOP_TYPE
        if word.text == OBJECT:
            continue
        if parents.setdefault(word.text, above) != above:
            refuse(word, f"one supertype, which is {parents[word.text]} already")
        if _is_below_itself(word.text, parents):
            refuse(word, "a type that is not its own supertype")
    for above in tuple(parents.values()):
        if above != TOP_TYPE:
            parents.setdefault(above, TOP_TYPE)
    return TypeTree(parents)


def _is_below_itself(name: str, parents: Mapping[str, str]) -> bool:
    above = parents.get(name)
    while above is not None and above != name:
        above = parents.get(above)
    return above == name
