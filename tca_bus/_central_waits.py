"""The task tree as the holds on resources see it: who works where, and who awaits whom."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

from tca_bus._handle import REFRESH_PERIOD
from tca_bus._protocol import Handling
from tca_bus.resources import Clause, Member
from tca_bus.tasktree import Node, Tree

FRESH = 3 * REFRESH_PERIOD
"""Wall seconds for which it counts that somebody awaits a task; it is said again each period."""


@dataclass
class TreeTasks:
    """A look into central's task tree; ``tree`` gives the one of now."""

    tree: Callable[[], Tree]
    _awaited: dict[str, dict[str, float]] = field(default_factory=dict)

    def note(self, child: str, *, task: str | None, holding: Sequence[str]) -> None:
        """The handler of ``task``, or who has these holds, waits for the end of ``child``."""
        self._forget_old()
        for waiter in [*([f"task {task}"] if task else []), *(f"hold {id}" for id in holding)]:
            self._awaited.setdefault(waiter, {})[child] = time.monotonic() + FRESH

    def waiting_tasks(self) -> list[str]:
        """The tasks whose handlers are known to await others."""
        self._forget_old()
        kinds = (waiter.split(" ", 1) for waiter in self._awaited)
        return [id for kind, id in kinds if kind == "task"]

    def attending(self, resource: str) -> Collection[str]:
        """The tasks that have a place in a handlers' resource."""
        return self.tree().pools.attending(resource)

    def is_handled(self, task: str) -> bool:
        """Whether the handler of a task has ended, and the task has not."""
        node = self._node(task)
        return node is not None and node.is_alive and node.handling is Handling.HANDLED

    def awaited(self, task: str) -> Collection[str]:
        """The tasks whose end the handler of a task waits for."""
        node = self._node(task)
        return self._fresh(f"task {task}") if node is not None and node.is_handling else ()

    def awaited_with(self, hold: str) -> Collection[str]:
        """The tasks whose end is waited for by whoever has a hold."""
        return self._fresh(f"hold {hold}")

    def clauses(self, task: str) -> Sequence[Clause]:
        """What a task waits for that is not being handled."""
        return [_clause(tasks, holds) for tasks, holds in self.tree().waits(task)]

    def _node(self, task: str) -> Node | None:
        tree = self.tree()
        return tree.node(task) if task in tree else None

    def _fresh(self, waiter: str) -> list[str]:
        now = time.monotonic()
        return [child for child, until in self._awaited.get(waiter, {}).items() if until > now]

    def _forget_old(self) -> None:
        for waiter in list(self._awaited):
            fresh = self._fresh(waiter)
            self._awaited[waiter] = {child: self._awaited[waiter][child] for child in fresh}
            if not fresh:
                del self._awaited[waiter]


def _clause(tasks: set[str], holds: set[str]) -> Clause:
    members: set[Member] = {("task", id) for id in tasks}
    members |= {("hold", id) for id in holds}
    return Clause(1, frozenset(members))
