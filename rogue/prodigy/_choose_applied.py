"""Which of several ready operators is applied when no rule says so."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rogue.prodigy._effects import gross_changes, makes
from rogue.prodigy._grounding import World
from rogue.prodigy._nodes import Node
from rogue.prodigy._terms import Literal

Signed = tuple[str, bool]
"""A predicate, and whether it is made true or false."""


def choose_applied(ready: list[Node], world: World) -> tuple[Node, str]:
    """Return the operator to apply of ``ready`` (newest first), and the reason.

    The order is PRODIGY4.0's: an operator that is free to go (nobody deletes what it adds, it
    deletes nobody's precondition), of several the newest; else one whose precondition another
    would delete and that threatens nobody; else the one with the fewest conflicts, of several
    the oldest.
    """
    if len(ready) == 1:
        return ready[0], "only one"
    conflicts = _Conflicts(ready, world)
    free = next((n for n in ready if conflicts.is_free(n)), None)
    if free is not None:
        return free, "free to go"
    threatened = (n for n in ready if conflicts.threatened(n) and not conflicts.threatens(n))
    peaceful = next(threatened, None)
    if peaceful is not None:
        return peaceful, "threatened by others"
    fewest = min(reversed(ready), key=lambda n: conflicts.clobbered(n) + conflicts.threatens(n))
    return fewest, "fewest conflicts"


class _Conflicts:
    """How often each operator's adds are clobbered, it threatens, and it is threatened."""

    def __init__(self, ready: list[Node], world: World) -> None:
        self._world = world
        self._makers = _Makers(ready, world)
        self._needing: dict[Signed, dict[Literal, list[Node]]] = {}
        for node in ready:
            for literal in _needs(node):
                group = self._needing.setdefault((literal.predicate, literal.positive), {})
                group.setdefault(literal, []).append(node)

    def is_free(self, node: Node) -> bool:
        """Say whether nobody deletes what ``node`` adds, and it deletes nobody's precondition."""
        return not any(self._clobbered(node)) and not any(self._threatens(node))

    def clobbered(self, node: Node) -> int:
        """Return how often others delete what ``node`` adds."""
        return sum(self._clobbered(node))

    def threatens(self, node: Node) -> int:
        """Return how often ``node`` deletes the precondition of another."""
        return sum(self._threatens(node))

    def threatened(self, node: Node) -> int:
        """Return how often others delete a precondition of ``node``."""
        return sum(self._others(self._makers.of(p.negated()), node) for p in _needs(node))

    def _clobbered(self, node: Node) -> Iterator[int]:
        assert node.instance is not None
        adds, _ = gross_changes(node.instance, self._world)
        for fact in adds:
            yield self._others(self._makers.of(fact.negated()), node)

    def _threatens(self, node: Node) -> Iterator[int]:
        assert node.instance is not None
        touched = {(e.atom.predicate, not e.adds) for e in node.instance.operator.effects}
        for signed in touched:
            for literal, owners in self._needing.get(signed, {}).items():
                if node in self._makers.of(literal.negated()):
                    yield self._others(owners, node)

    @staticmethod
    def _others(nodes: Collection[Node], node: Node) -> int:
        return len(nodes) - (node in nodes)


class _Makers:
    """Which of the ready operators would make a literal true; worked out where it is asked."""

    def __init__(self, ready: list[Node], world: World) -> None:
        self._world = world
        self._by_operator: dict[str, list[Node]] = {}
        for node in ready:
            assert node.instance is not None
            self._by_operator.setdefault(node.instance.name, []).append(node)
        self._known: dict[Literal, frozenset[Node]] = {}
        self._indexes: dict[Signed, tuple[dict[Literal, list[Node]], list[Node]]] = {}

    def of(self, literal: Literal) -> frozenset[Node]:
        """Return the operators that make ``literal`` true, were it false."""
        if literal not in self._known:
            exact, anything = self._index((literal.predicate, literal.positive))
            maybe = [*exact.get(literal, ()), *anything]
            self._known[literal] = frozenset(
                n for n in maybe if n.instance and makes(n.instance, literal, self._world)
            )
        return self._known[literal]

    def _index(self, signed: Signed) -> tuple[dict[Literal, list[Node]], list[Node]]:
        """Return the operators by the literal that an effect makes, and those that make many."""
        if signed in self._indexes:
            return self._indexes[signed]
        exact: dict[Literal, list[Node]] = {}
        anything: list[Node] = []
        for nodes in self._by_operator.values():
            operator = nodes[0].operator
            assert operator is not None
            effects = [e for e in operator.effects if (e.atom.predicate, e.adds) == signed]
            for node in nodes if effects else ():
                assert node.instance is not None
                bindings = node.instance.bindings
                for effect in effects:
                    if all(name in bindings for name in effect.atom.variables()):
                        made = effect.atom.ground(bindings, positive=effect.adds)
                        exact.setdefault(made, []).append(node)
                    else:
                        anything.append(node)
        self._indexes[signed] = exact, anything
        return exact, anything


def _needs(node: Node) -> tuple[Literal, ...]:
    return node.instance.preconditions if node.instance is not None else ()
