"""The chosen and not yet applied operators: which still matter, what they need, which are ready.

An operator matters while there is a chain of false goals from *finish* to it: an operator whose
goal holds already, or whose every consumer was applied or dropped, dangles and is left alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rogue.prodigy._instance import Instance
from rogue.prodigy._nodes import Node, Situation
from rogue.prodigy._terms import Literal

Needs = Callable[[Node], tuple[Literal, ...]]
"""Preconditions of a binding node; those of *finish* change while the search runs."""


class Tail:
    """Answers about one situation; made once per expansion."""

    def __init__(self, situation: Situation, needs: Needs) -> None:
        self._situation = situation
        self._needs = needs
        self._servers = {node.goal_node: node for node in situation.tail}
        self.finish = situation.tail[0] if situation.tail else None
        self._live = self._reachable(situation.tail[:1])

    def _server(self, goal: Literal) -> Node | None:
        goal_node = self._situation.expanded.get(goal)
        return self._servers.get(goal_node) if goal_node else None

    def _reachable(self, start: Iterable[Node]) -> dict[Node, None]:
        found: dict[Node, None] = dict.fromkeys(start)
        agenda = list(found)
        while agenda:
            for goal in self.lacking(agenda.pop()):
                server = self._server(goal)
                if server is not None and server not in found:
                    found[server] = None
                    agenda.append(server)
        return found

    def lacking(self, node: Node) -> tuple[Literal, ...]:
        """Return the preconditions of a binding node that are false."""
        holds = self._situation.state.holds
        return tuple(p for p in self._needs(node) if not holds(p))

    def goals(self) -> tuple[Literal, ...]:
        """Return the goals of the problem."""
        return self._needs(self.finish) if self.finish else ()

    def live(self) -> list[Node]:
        """Return the operators that matter, *finish* included, newest first."""
        return sorted(self._live, key=lambda node: -node.number)

    def pending(self) -> dict[Literal, list[Node]]:
        """Return the pending goals, those of the newest operator first, with who needs each."""
        goals: dict[Literal, list[Node]] = {}
        for node in self.live():
            for goal in self.lacking(node):
                if goal not in self._situation.expanded:
                    goals.setdefault(goal, []).append(node)
        return goals

    def ready(self) -> list[Node]:
        """Return the operators whose preconditions hold, newest first, *finish* left out."""
        return [n for n in self.live() if n is not self.finish and not self.lacking(n)]

    def consumers(self, goal: Literal) -> list[Node]:
        """Return the operators that matter and need ``goal``, newest first."""
        return [n for n in self.live() if goal in self._needs(n)]

    def top_level_goals(self, candidate: Literal | Instance) -> list[Literal]:
        """Return the goals of the problem from which a chain of false goals leads here."""
        reached: list[Literal] = []
        for goal in self.lacking(self.finish) if self.finish else ():
            server = self._server(goal)
            below = self._reachable([server]) if server else {}
            if candidate == goal or any(self._is_at(node, candidate) for node in below):
                reached.append(goal)
        return reached

    def _is_at(self, node: Node, candidate: Literal | Instance) -> bool:
        if isinstance(candidate, Instance):
            return node.instance is candidate or node.number == candidate.node
        return candidate in self._needs(node)

    def by_top_level_goal(self, nodes: list[Node]) -> list[Node]:
        """Return ``nodes`` grouped by the top-level goal they serve, as those were posed."""
        rank: dict[Node, int] = {}
        for at, goal in enumerate(self.lacking(self.finish) if self.finish else ()):
            server = self._server(goal)
            for node in self._reachable([server]) if server else ():
                rank.setdefault(node, at)
        return sorted(nodes, key=lambda node: rank.get(node, len(rank)))
