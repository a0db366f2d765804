"""Variables that may be used at a place of a PDDL text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from rogue.prodigy._expressions import VariableSpec
from rogue.prodigy._reader import Word
from rogue.prodigy._terms import Term, Variable
from rogue.prodigy._types import TypeSpec


@dataclass(frozen=True, slots=True)
class Typed:
    """A term and the types that its values may have."""

    term: Term
    types: TypeSpec


@dataclass(frozen=True, slots=True)
class Scope:
    """What the variables of a text stand for.

    PDDL lets an inner variable hide an outer one of the same name. Bindings do not nest, so the
    inner one is given another name.

    Attributes:
        names: Terms by the variable's name, without question mark.
        taken: Names that are in use anywhere in the same action, shared by its scopes.
    """

    names: Mapping[str, Typed] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)

    def declare(
        self, declared: Iterable[tuple[Word, TypeSpec]]
    ) -> tuple[Scope, tuple[VariableSpec, ...]]:
        """Return the scope within a list of variables, and the variables under their own names."""
        names = dict(self.names)
        specs: list[VariableSpec] = []
        for word, types in declared:
            spec = VariableSpec(self._free_name(word.text), types)
            names[word.text] = Typed(Variable(spec.name), types)
            specs.append(spec)
        return replace(self, names=names), tuple(specs)

    def binding(self, names: Mapping[str, Typed]) -> Scope:
        """Return the scope of a definition whose parameters stand for the terms of ``names``."""
        return replace(self, names=names)

    def _free_name(self, name: str) -> str:
        fresh, number = f"<{name}>", 1
        while fresh in self.taken:
            number += 1
            fresh = f"<{name}:{number}>"
        self.taken.add(fresh)
        return fresh
