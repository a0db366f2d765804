"""The chosen and not yet applied operators: which still matter, what they need, which are ready.

An operator matters while there is a chain of false goals from *finish* to it: an operator whose
goal holds already, or whose every consumer was applied or dropped, dangles and is left alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING

from rogue.prodigy._instance import Instance
from rogue.prodigy._terms import Literal

if TYPE_CHECKING:
    from rogue.prodigy._nodes import Node
    from rogue.prodigy._situation import Situation


class Tail:
    """Answers about one situation, each worked out once.

    Attributes:
        live: Numbers of nodes known to matter, those known before among them.
    """

    def __init__(self, situation: Situation) -> None:
        self._situation = situation
        self.live = situation.live
        self._dangling: set[Node] = set()

    @property
    def finish(self) -> Node | None:
        """The node of *finish*."""
        return self._situation.finish

    def release(self) -> None:
        """Let go what can be worked out again; what is known to matter is kept."""
        for name in ("_pending", "_ready", "_lacking_goals", "newest"):
            self.__dict__.pop(name, None)
        self._dangling = set()

    def _waiting_for(self, node: Node) -> tuple[Node, ...]:
        """Return the operators that need the goal of ``node`` while that is false."""
        situation, goal = self._situation, node.goal
        if goal is None or situation.expanded.get(goal) is not node.goal_node:
            return ()
        return situation.needed.get(goal, ())

    def is_live(self, node: Node) -> bool:
        """Say whether a chain of false goals leads from *finish* to ``node``."""
        came_from: dict[Node, Node | None] = {node: None}
        agenda = [node]
        while agenda:
            at = agenda.pop()
            if at is self.finish or at.number in self.live:
                self._note_live(at, came_from)
                return True
            for consumer in self._waiting_for(at):
                if consumer not in came_from and consumer not in self._dangling:
                    came_from[consumer] = at
                    agenda.append(consumer)
        self._dangling.update(came_from)
        return False

    def _note_live(self, node: Node | None, came_from: dict[Node, Node | None]) -> None:
        while node is not None:
            if node.number not in self.live:
                self.live = self.live.set(node.number, None)
            node = came_from[node]

    def goals(self) -> tuple[Literal, ...]:
        """Return the goals of the problem."""
        return self._situation.needs(self.finish) if self.finish is not None else ()

    @cached_property
    def newest(self) -> Node | None:
        """The newest operator that matters, *finish* left out."""
        tail = self._situation.tail
        for number in sorted(tail, reverse=True):
            node = tail[number]
            if node is not self.finish and self.is_live(node):
                return node
        return None

    def pending(self) -> dict[Literal, tuple[Node, ...]]:
        """Return the pending goals, those of the newest operator first, with who needs each."""
        return dict(self._pending)

    @cached_property
    def _pending(self) -> dict[Literal, tuple[Node, ...]]:
        situation = self._situation
        needing = {node for goal in situation.wanted for node in situation.needed[goal]}
        found: dict[Literal, tuple[Node, ...]] = {}
        for node in sorted(filter(self.is_live, needing), key=lambda n: -n.number):
            for goal in situation.needs(node):
                if goal in situation.wanted and goal not in found:
                    found[goal] = self.consumers(goal)
        return found

    def ready(self) -> list[Node]:
        """Return the operators whose preconditions hold, newest first, *finish* left out."""
        return list(self._ready)

    @cached_property
    def _ready(self) -> list[Node]:
        free = [n for n in self._situation.free.values() if n.is_applicable()]
        return sorted(filter(self.is_live, free), key=lambda node: -node.number)

    def consumers(self, goal: Literal) -> tuple[Node, ...]:
        """Return the operators that matter and need ``goal``, newest first."""
        return tuple(filter(self.is_live, self._situation.needed.get(goal, ())))

    def top_level_goals(self, candidate: Literal | Instance) -> list[Literal]:
        """Return the goals of the problem from which a chain of false goals leads here."""
        if self.finish is None:
            return []
        if isinstance(candidate, Instance):
            node = self._situation.tail.get(candidate.node)
            return self._goals_above([node] if node is not None else [])
        above = {candidate, *self._goals_above(self._situation.needed.get(candidate, ()))}
        places = self._lacking_goals
        return sorted((goal for goal in above if goal in places), key=places.__getitem__)

    @cached_property
    def _lacking_goals(self) -> dict[Literal, int]:
        lacking = self._situation.lacks(self.finish) if self.finish is not None else ()
        return {goal: at for at, goal in enumerate(lacking)}

    def _goals_above(self, start: Iterable[Node]) -> list[Literal]:
        seen = set(start)
        agenda, reached = list(seen), set[Literal]()
        while agenda:
            node = agenda.pop()
            for consumer in self._waiting_for(node):
                if consumer is self.finish and node.goal is not None:
                    reached.add(node.goal)
                elif consumer not in seen:
                    seen.add(consumer)
                    agenda.append(consumer)
        return sorted(reached, key=lambda goal: self._lacking_goals.get(goal, 0))

    def by_top_level_goal(self, nodes: list[Node]) -> list[Node]:
        """Return ``nodes`` grouped by the top-level goal they serve, as those were posed."""
        places = self._lacking_goals

        def place(node: Node) -> int:
            return min((places[g] for g in self._goals_above([node])), default=len(places))

        return sorted(nodes, key=place)
