"""Types with subtypes, and the objects that have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rogue.prodigy._errors import UnknownNameError
from rogue.prodigy._terms import Value

TOP_TYPE = "top-type"


@dataclass(frozen=True, slots=True)
class TypeSpec:
    """A set of types.

    A type belongs to it if the nearest of its ancestors, itself first, that ``names`` or
    ``excluded`` mention stands in ``names``. Every combination by and, or and not is one.
    """

    names: tuple[str, ...] = (TOP_TYPE,)
    excluded: tuple[str, ...] = ()

    def __str__(self) -> str:
        text = self.names[0] if len(self.names) == 1 else "(or " + " ".join(self.names) + ")"
        if not self.excluded:
            return text
        return f"(and {text} " + " ".join(f"(not {name})" for name in self.excluded) + ")"


@dataclass(frozen=True, slots=True)
class TypeTree:
    """A single-inheritance tree of types under ``top-type``.

    Attributes:
        parents: Supertype of each type but ``top-type``.
        infinite: Test function of each infinite type, by name of the type.
    """

    parents: Mapping[str, str] = field(default_factory=dict)
    infinite: Mapping[str, str] = field(default_factory=dict)
    _members: dict[TypeSpec, frozenset[str]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def names(self) -> tuple[str, ...]:
        """Return all type names."""
        return (*self.finite(), *self.infinite)

    def finite(self) -> tuple[str, ...]:
        """Return the names of the types that objects can have."""
        return (TOP_TYPE, *self.parents)

    def __contains__(self, name: str) -> bool:
        return name == TOP_TYPE or name in self.parents or name in self.infinite

    def is_a(self, name: str, ancestor: str) -> bool:
        """Say whether ``name`` is ``ancestor`` or one of its subtypes."""
        while name != ancestor:
            if name not in self.parents:
                return ancestor == TOP_TYPE
            name = self.parents[name]
        return True

    def members(self, spec: TypeSpec) -> frozenset[str]:
        """Return the types that belong to ``spec``, infinite ones left out."""
        if spec not in self._members:
            mine = (name for name in self.finite() if self._belongs(name, spec))
            self._members[spec] = frozenset(mine)
        return self._members[spec]

    def _belongs(self, name: str, spec: TypeSpec) -> bool:
        while name not in spec.names and name not in spec.excluded:
            if name not in self.parents:
                return False
            name = self.parents[name]
        return name not in spec.excluded

    def infinite_of(self, spec: TypeSpec) -> tuple[str, ...]:
        """Return the infinite types that belong to ``spec``."""
        return tuple(name for name in spec.names if name in self.infinite)

    def spec(self, members: frozenset[str]) -> TypeSpec:
        """Return the specification to which exactly ``members`` belong, infinite ones too."""
        names = [name for name in self.infinite if name in members]
        excluded: list[str] = []
        for name in self.finite():
            above = name != TOP_TYPE and self.parents[name] in members
            if (name in members) != above:
                (excluded if above else names).append(name)
        return TypeSpec(tuple(names), tuple(excluded))


class Objects:
    """The objects of a problem by type, in the order of their declaration; immutable."""

    __slots__ = ("_cache", "_positions", "tree", "types_of")

    def __init__(self, tree: TypeTree, types_of: Mapping[str, str]) -> None:
        self.tree = tree
        self.types_of = types_of
        self._cache: dict[TypeSpec, tuple[str, ...]] = {}
        self._positions = {name: at for at, name in enumerate(types_of)}

    def position(self, value: Value) -> tuple[bool, float, str]:
        """Return a key that sorts objects as declared, after the numbers in their order."""
        if isinstance(value, str):
            return (True, self._positions.get(value, len(self._positions)), value)
        return (False, value, "")

    def __contains__(self, name: Value) -> bool:
        return name in self.types_of

    def names(self) -> tuple[str, ...]:
        """Return all objects."""
        return tuple(self.types_of)

    def is_a(self, value: Value, spec: TypeSpec) -> bool:
        """Say whether ``value`` is an object of one of the types of ``spec``."""
        kind = self.types_of.get(value) if isinstance(value, str) else None
        return kind is not None and kind in self.tree.members(spec)

    def of(self, spec: TypeSpec) -> tuple[str, ...]:
        """Return the objects of the types of ``spec``."""
        if spec not in self._cache:
            members = self.tree.members(spec)
            mine = (name for name, kind in self.types_of.items() if kind in members)
            self._cache[spec] = tuple(mine)
        return self._cache[spec]

    def with_object(self, name: str, kind: str) -> Objects:
        """Return these objects and one more; UnknownNameError if there is no such type."""
        if kind not in self.tree:
            raise UnknownNameError("type", kind, self.tree.names())
        return Objects(self.tree, {**self.types_of, name: kind})
