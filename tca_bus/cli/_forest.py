"""The task tree as a viewer keeps it: statuses in, in any order; what changed out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field

from tca_bus._protocol import TaskState, TaskStatus

WAITING = frozenset({TaskState.INACTIVE, TaskState.PENDING})
"""The states of nodes that have not begun."""

MOST_ENDED = 20
"""Top-level tasks that have ended and are still kept."""


@dataclass
class Forest:
    """The nodes that are known, and how they hang together.

    ``only`` is the id of the task to keep with all below it, None for all tasks. ``shape``
    grows whenever nodes came, went, began or ended, ``version`` with every other change of a
    state too: what a drawing may remember until then.
    """

    only: str | None = None
    most_ended: int = MOST_ENDED
    shape: int = 0
    version: int = 0
    nodes: dict[str, TaskStatus] = field(default_factory=dict)
    counts: Counter[TaskState] = field(default_factory=Counter)
    _below: dict[str, dict[str, None]] = field(default_factory=dict)
    _tops: dict[str, None] = field(default_factory=dict)
    _ended_tops: dict[str, None] = field(default_factory=dict)
    _orphans: dict[str, list[str]] = field(default_factory=dict)
    _alive: Counter[str] = field(default_factory=Counter)

    def take(self, status: TaskStatus) -> bool:
        """Take a status in; False when it says nothing new or is about another task."""
        known = self.nodes.get(status.id)
        if known is None:
            if not self._is_wanted(status):
                return False
            self._add(status)
        elif known.is_ended or status.sequence <= known.sequence:
            return False
        else:
            self._change(known, status)
        self._forget_oldest()
        return True

    def replace(self, statuses: Iterable[TaskStatus], *, keep: Collection[str] = ()) -> None:
        """Take in all that there is: what is not named has ended unseen, but for ``keep``.

        It is gone with all below it. Nodes whose end was seen stay, named or not.
        """
        listed = {status.id: status for status in statuses}
        for status in listed.values():
            self.take(status)
        kept = listed.keys() | set(keep)
        gone = [id for id, node in self.nodes.items() if not node.is_ended and id not in kept]
        for id in gone:
            if id in self.nodes:
                self._remove(id)

    def tops(self) -> list[str]:
        """The nodes without a parent here, oldest first."""
        return list(self._tops)

    def children(self, id: str) -> list[str]:
        """The nodes below one, oldest first."""
        return list(self._below.get(id, ()))

    def has_ended(self, id: str) -> bool:
        """Whether a node and all below it have ended."""
        return not self._alive[id]

    def subtree(self, id: str) -> Iterator[str]:
        """A node and all below it."""
        stack = [id]
        while stack:
            node = stack.pop()
            yield node
            stack += self._below.get(node, ())

    def _is_wanted(self, status: TaskStatus) -> bool:
        return self.only is None or status.id == self.only or status.parent in self.nodes

    def _add(self, status: TaskStatus) -> None:
        self.nodes[status.id] = status
        self.counts[status.state] += 1
        self.shape += 1
        self.version += 1
        if status.parent in self.nodes:
            self._below.setdefault(status.parent, {})[status.id] = None
        else:
            self._tops[status.id] = None
            if status.parent is not None:
                self._orphans.setdefault(status.parent, []).append(status.id)
        self._note_alive(status.id, int(not status.is_ended) + self._adopt(status.id))

    def _adopt(self, parent: str) -> int:
        """Put nodes that came before their parent below it; gives how many are alive there."""
        alive = 0
        for id in self._orphans.pop(parent, ()):
            if id in self._tops:
                self._drop_top(id)
                self._below.setdefault(parent, {})[id] = None
                alive += self._alive[id]
        return alive

    def _change(self, known: TaskStatus, status: TaskStatus) -> None:
        self.nodes[status.id] = status
        if known.state is status.state:
            return
        self.counts[known.state] -= 1
        self.counts[status.state] += 1
        self.version += 1
        if status.is_ended:
            self._note_alive(status.id, self._alive[status.id] - 1)
        if status.is_ended or known.state in WAITING:
            self.shape += 1

    def _note_alive(self, id: str, count: int) -> None:
        """Set how many of a node and those below it are alive, and tell its ancestors."""
        change = count - self._alive[id]
        self._alive[id] = count
        top, parent = id, self.nodes[id].parent
        while parent in self.nodes:
            self._alive[parent] += change
            top, parent = parent, self.nodes[parent].parent
        if self._alive[top]:
            self._ended_tops.pop(top, None)
        else:
            self._ended_tops.setdefault(top)

    def _forget_oldest(self) -> None:
        while len(self._ended_tops) > self.most_ended:
            oldest = next((id for id in self._ended_tops if id != self.only), None)
            if oldest is None:
                return
            self._remove(oldest)

    def _remove(self, top: str) -> None:
        self._note_alive(top, 0)
        parent = self.nodes[top].parent
        for id in list(self.subtree(top)):
            self.counts[self.nodes.pop(id).state] -= 1
            self._below.pop(id, None)
            del self._alive[id]
        if top in self._tops:
            self._drop_top(top)
        elif parent is not None:
            del self._below[parent][top]
        self.shape += 1
        self.version += 1

    def _drop_top(self, id: str) -> None:
        del self._tops[id]
        self._ended_tops.pop(id, None)
