"""Abstraction levels of goals, worked out from the domain.

A predicate is on a higher level than another if achieving it may call for the other and never the
other way round; what one operator changes together is on one level. Goals of a higher level
are better achieved first, since achieving those of a lower one does not undo them.

Source: PRODIGY4.0's ``use-abs-level``, after Knoblock's ALPINE (1991).
"""

from __future__ import annotations

from collections.abc import Iterable

from rogue.prodigy._domain import Domain, Operator
from rogue.prodigy._expressions import atoms
from rogue.prodigy._terms import Literal

Graph = dict[str, set[str]]


class AbstractionLevels:
    """The levels of the predicates of a domain."""

    def __init__(self, domain: Domain) -> None:
        graph: Graph = {}
        for operator in (*domain.operators, *domain.inference_rules):
            _add(operator, graph, domain)
        self._levels = _heights(graph)
        self._is_flat = len(set(self._levels.values())) < 2

    def of(self, goal: Literal) -> int:
        """Return the level of a goal; 0 is the lowest."""
        return self._levels.get(goal.predicate, 0)

    def sorted(self, goals: Iterable[Literal]) -> list[Literal]:
        """Return goals by level, the highest first, otherwise in their order."""
        if self._is_flat:
            return list(goals)
        return sorted(goals, key=lambda goal: -self.of(goal))


def _add(operator: Operator, graph: Graph, domain: Domain) -> None:
    """Add that the effects of an operator are equals, and not below what it may call for."""
    made = list(dict.fromkeys(effect.atom.predicate for effect in operator.effects))
    conditions = (operator.precondition, *(effect.condition for effect in operator.effects))
    needed = {
        a.predicate for c in conditions for a in atoms(c) if not domain.is_static(a.predicate)
    }
    for name in made:
        graph.setdefault(name, set()).update(needed)
        graph[name].update(made)
    for name in needed:
        graph.setdefault(name, set())


def _heights(graph: Graph) -> dict[str, int]:
    """Return for each vertex the longest way down, with each cycle taken as one vertex."""
    heights: dict[str, int] = {}
    for group in _components(graph):
        below = {other for name in group for other in graph[name]} - set(group)
        height = max((heights[name] + 1 for name in below), default=0)
        heights.update(dict.fromkeys(group, height))
    return heights


def _components(graph: Graph) -> list[list[str]]:
    """Return the strongly connected components, those below first (Tarjan, without recursion)."""
    found: list[list[str]] = []
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    for start in graph:
        agenda = [(start, iter(sorted(graph[start])))] if start not in index else []
        if agenda:
            index[start] = low[start] = len(index)
            stack.append(start)
        while agenda:
            name, others = agenda[-1]
            other = next(others, None)
            if other is None:
                agenda.pop()
                if agenda:
                    low[agenda[-1][0]] = min(low[agenda[-1][0]], low[name])
                if low[name] == index[name]:
                    at = stack.index(name)
                    found.append(stack[at:])
                    del stack[at:]
            elif other not in index:
                index[other] = low[other] = len(index)
                stack.append(other)
                agenda.append((other, iter(sorted(graph[other]))))
            elif other in stack:
                low[name] = min(low[name], index[other])
    return found
