"""Types with subtypes, and the objects that have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rogue.prodigy._errors import UnknownNameError
from rogue.prodigy._terms import Value

TOP_TYPE = "top-type"


@dataclass(frozen=True, slots=True)
class TypeTree:
    """A single-inheritance tree of types under ``top-type``.

    Attributes:
        parents: Supertype of each type but ``top-type``.
        infinite: Test function of each infinite type, by name of the type.
    """

    parents: Mapping[str, str] = field(default_factory=dict)
    infinite: Mapping[str, str] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        """Return all type names."""
        return (TOP_TYPE, *self.parents, *self.infinite)

    def __contains__(self, name: str) -> bool:
        return name == TOP_TYPE or name in self.parents or name in self.infinite

    def is_a(self, name: str, ancestor: str) -> bool:
        """Say whether ``name`` is ``ancestor`` or one of its subtypes."""
        while name != ancestor:
            if name not in self.parents:
                return ancestor == TOP_TYPE
            name = self.parents[name]
        return True


@dataclass(frozen=True, slots=True)
class TypeSpec:
    """A set of types: any of ``names``, none of ``excluded``."""

    names: tuple[str, ...] = (TOP_TYPE,)
    excluded: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.names[0] if len(self.names) == 1 else "(or " + " ".join(self.names) + ")"


class Objects:
    """The objects of a problem by type, in the order of their declaration; immutable."""

    __slots__ = ("_cache", "_positions", "tree", "types_of")

    def __init__(self, tree: TypeTree, types_of: Mapping[str, str]) -> None:
        self.tree = tree
        self.types_of = types_of
        self._cache: dict[TypeSpec, tuple[str, ...]] = {}
        self._positions = {name: at for at, name in enumerate(types_of)}

    def position(self, value: Value) -> tuple[float, str]:
        """Return a key that sorts objects as declared, after the numbers in their order."""
        if isinstance(value, str):
            return (float(self._positions.get(value, len(self._positions))), value)
        return (float("-inf"), f"{value:+030.9f}")

    def __contains__(self, name: Value) -> bool:
        return name in self.types_of

    def names(self) -> tuple[str, ...]:
        """Return all objects."""
        return tuple(self.types_of)

    def is_a(self, value: Value, spec: TypeSpec) -> bool:
        """Say whether ``value`` is an object of one of the types of ``spec``."""
        kind = self.types_of.get(value) if isinstance(value, str) else None
        if kind is None:
            return False
        tree = self.tree
        return any(tree.is_a(kind, name) for name in spec.names) and not any(
            tree.is_a(kind, name) for name in spec.excluded
        )

    def of(self, spec: TypeSpec) -> tuple[str, ...]:
        """Return the objects of the types of ``spec``."""
        if spec not in self._cache:
            self._cache[spec] = tuple(o for o in self.types_of if self.is_a(o, spec))
        return self._cache[spec]

    def with_object(self, name: str, kind: str) -> Objects:
        """Return these objects and one more; UnknownNameError if there is no such type."""
        if kind not in self.tree:
            raise UnknownNameError("type", kind, self.tree.names())
        return Objects(self.tree, {**self.types_of, name: kind})
