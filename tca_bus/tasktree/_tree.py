"""The task tree: one event in, a list of effects out."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

from tca_bus._errors import NoHandlerError, RefusedError
from tca_bus._protocol import SubmitTask, TaskStatus
from tca_bus.tasktree._admission import ROOT, check_submission
from tca_bus.tasktree._effects import (
    Cancel,
    Dispatch,
    Effect,
    Ended,
    Publish,
    Record,
    WaitForHandler,
)
from tca_bus.tasktree._events import (
    LAST_SIBLING,
    Dispatched,
    Event,
    HandlerLost,
    HandlerMissing,
    KillRequested,
    ProviderAppeared,
    ProviderLost,
    RecordedEvent,
    Released,
    Reported,
    Submitted,
    Taken,
)
from tca_bus.tasktree._machine import Machine
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._pools import Pools
from tca_bus.tasktree._words import waiting_for

TOMBSTONE_SECONDS = 60.0
"""How long a kill is remembered that came before its task."""

LOST_PROVIDER_WAIT = 30.0
"""Seconds that an accepted node waits when the last module that handles it went away."""

GENERATION_STEP = 1_000_000
"""Sequence numbers begin here times the generation, so that a restart never goes back."""


class Tree:
    """All task nodes that are alive, and what they wait for.

    Pure: `apply` changes the tree and returns what is to be done, in order. The `Record`
    effects, replayed in order on a fresh tree, give the same tree.

    Args:
        generation: How often this tree was rebuilt from its records; sequence numbers of a
            later generation are higher than all of an earlier one.
    """

    def __init__(self, *, generation: int = 0) -> None:
        self._base = generation * GENERATION_STEP
        self._pools = Pools()
        self._machine = Machine(self._pools)
        self._last_of_sender: dict[str, str] = {}
        self._tombstones: dict[str, KillRequested] = {}
        self._changed: dict[str, None] = {}
        self._is_replaying = False

    def __contains__(self, id: object) -> bool:
        return id in self._machine.nodes

    def __len__(self) -> int:
        return len(self._machine.nodes)

    def apply(self, event: Event) -> list[Effect]:
        """Let one event happen; gives the effects in the order in which they are due.

        Raises:
            RefusedError: a `Submitted` that cannot be, see `check`.
        """
        records: list[Effect] = []
        others: list[Effect] = []
        events = deque([event])
        while events:
            current = events.popleft()
            record = self._step(current, events, others)
            if record is not None:
                records.append(record)
            self._decide(current.time, events, others)
        return records + others + self._publish() + self._free()

    def replay(self, events: Iterable[RecordedEvent]) -> list[Effect]:
        """Apply recorded events; gives what still has to be done for the nodes that are left.

        That is: `Dispatch` again for every node that a module has (it tells tries apart), and
        `Ended` for top-level tasks whose end was recorded by its events only.
        """
        effects: list[Effect] = []
        self._is_replaying = True
        for event in events:
            effects += [e for e in self.apply(event) if isinstance(e, Ended)]
        self._is_replaying = False
        for node in self._machine.nodes.values():
            node.sequence = max(node.sequence, self._base)
            effects += self._resume(node)
        self._pools.forget_missing()
        self._decide(0.0, deque(), effects)
        return effects

    def check(self, task: SubmitTask) -> None:
        """Refuse a submission that cannot become a node. A repeated one is fine.

        Raises:
            RefusedError: the id is taken by another message, the flags contradict each other,
                the parent takes no children, or the node could never start.
            NoHandlerError: nobody handles it and it may not wait.
        """
        check_submission(task, self._machine)
        known = self._pools.names()
        if task.id not in self and task.name not in known and not task.wait_for_handler:
            raise NoHandlerError(task.name, known)

    def check_kill(self, id: str) -> None:
        """Refuse to kill what is above all tasks.

        Raises:
            RefusedError: the id is that of the root.
        """
        if id == ROOT:
            raise RefusedError("killing the root", "it ends only with central; name a task")

    def status(self, id: str) -> TaskStatus:
        """The status of a node.

        Raises:
            KeyError: there is no such node.
        """
        return self._status(self._machine.nodes[id])

    def statuses(self, id: str | None = None) -> list[TaskStatus]:
        """The node and all below it, or all nodes; parents come before their children.

        Raises:
            KeyError: there is no such node.
        """
        roots = [id] if id is not None else self.roots()
        return [self._status(node) for root in roots for node in self._machine.below(root)]

    def roots(self) -> list[str]:
        """The ids of the top-level tasks, oldest first."""
        return [node.id for node in self._machine.nodes.values() if node.task.parent is None]

    def root_of(self, id: str) -> str:
        """The id of the top-level task above a node; the id itself when it is unknown."""
        node = self._machine.nodes.get(id)
        if node is None:
            return id
        return [node, *self._machine.ancestors(node)][-1].id

    def holders(self) -> dict[str, str]:
        """The incarnations that are present or have nodes, with their modules' names."""
        return self._pools.incarnations()

    def is_missing(self, id: str, number: int) -> bool:
        """Whether the wait for a handler that `WaitForHandler` told of still lasts."""
        return self._pools.is_missing(id, number)

    def is_current(self, id: str, attempt: int) -> bool:
        """Whether a module has this try of the node now."""
        node = self._machine.nodes.get(id)
        return node is not None and node.attempt == attempt and node.is_handling

    def submission(self, id: str) -> SubmitTask:
        """The submission that made the node.

        Raises:
            KeyError: there is no such node.
        """
        return self._machine.nodes[id].task

    def _step(self, event: Event, events: deque[Event], effects: list[Effect]) -> Record | None:
        match event:
            case ProviderAppeared():
                self._pools.appear(event.module, event.incarnation, event.capacities)
                return None
            case ProviderLost():
                events += self._losses(event)
                return None
            case _:
                return self._step_recorded(event, effects)

    def _losses(self, event: ProviderLost) -> list[HandlerLost]:
        """What the module had, the deepest first: a parent fails knowing what failed below it."""
        module, ids = self._pools.lose(event.incarnation)
        nodes = [self._machine.nodes[id] for id in ids]
        nodes.sort(key=lambda node: -len(list(self._machine.ancestors(node))))
        return [HandlerLost(event.time, node.id, node.attempt, module) for node in nodes]

    def _step_recorded(self, event: RecordedEvent, effects: list[Effect]) -> Record | None:
        if not self._happens(event):
            return None
        if isinstance(event, Submitted):
            event = self._ordered(event)
        record = self._record(event)
        match event:
            case Submitted():
                self._submit(event)
            case KillRequested():
                self._kill(event)
            case Dispatched():
                self._machine.dispatched(event)
                effects.append(_dispatch(event))
            case _:
                self._machine.follow(event)
        self._count()
        return record

    def _happens(self, event: RecordedEvent) -> bool:
        """Whether the event changes anything: those that come twice or too late do not."""
        node = self._machine.nodes.get(event.id)
        match event:
            case Submitted():
                check_submission(event.task, self._machine)
                return node is None
            case KillRequested():
                self.check_kill(event.id)
                return node is None or bool(node.alive if event.only_below else node.is_alive)
            case _:
                return node is not None and _concerns(event, node)

    def _record(self, event: RecordedEvent) -> Record:
        parent = event.task.parent if isinstance(event, Submitted) else None
        root = self.root_of(parent or event.id)
        node = self._machine.nodes.get(event.id)
        named = event.task if isinstance(event, Submitted) else node.task if node else None
        return Record(root, named.name if named else "", event)

    def _ordered(self, event: Submitted) -> Submitted:
        """The submission with its previous sibling, which its record has to name."""
        if event.previous != LAST_SIBLING:
            return event
        task = event.task
        if task.parent is None:
            previous = self._last_of_sender.get(task.sender)
        else:
            previous = next(reversed(self._machine.nodes[task.parent].children), None)
        if previous is None:
            return replace(event, previous=None)
        return replace(event, previous=previous, waits=self._machine.nodes[previous].ahead())

    def _submit(self, event: Submitted) -> None:
        task = event.task
        if task.parent is None:
            self._last_of_sender[task.sender] = task.id
        self._machine.add(event)
        tombstone = self._tombstones.pop(task.id, None)
        if tombstone is not None and event.time - tombstone.time <= TOMBSTONE_SECONDS:
            node = self._machine.nodes[task.id]
            self._machine.kill(event.time, node, tombstone.reason, only_below=False)

    def _kill(self, event: KillRequested) -> None:
        node = self._machine.nodes.get(event.id)
        if node is not None:
            self._machine.kill(event.time, node, event.reason, only_below=event.only_below)
            return
        oldest = event.time - TOMBSTONE_SECONDS
        fresh = {id: stone for id, stone in self._tombstones.items() if stone.time >= oldest}
        self._tombstones = {**fresh, event.id: event}

    def _decide(self, time: float, events: deque[Event], effects: list[Effect]) -> None:
        """Choose the next handler for a node that is ready; start waits where nobody is there.

        The choice happens before anything else does, since it was made for the tree as it is.
        """
        choice = self._pools.assign()
        if choice is not None:
            attempt = self._machine.nodes[choice.id].attempt + 1
            chosen = Dispatched(time, choice.id, attempt, choice.module, choice.incarnation)
            events.appendleft(chosen)
        if not self._is_replaying:
            events.extend(self._machine.crossings)
        self._machine.crossings.clear()
        for id, number in self._pools.newly_missing():
            seconds = _patience(self._machine.nodes[id])
            if seconds is not None:
                effects.append(WaitForHandler(id, number, seconds))
        effects += self._machine.cancels
        self._machine.cancels.clear()

    def _count(self) -> None:
        for id in self._machine.touched:
            node = self._machine.nodes[id]
            node.sequence = max(node.sequence, self._base) + 1
        self._changed.update(self._machine.touched)
        self._machine.touched.clear()

    def _publish(self) -> list[Effect]:
        changed = [Publish(self.status(id)) for id in self._changed]
        self._changed.clear()
        return list(changed)

    def _free(self) -> list[Effect]:
        effects: list[Effect] = []
        for root in self._machine.ended_roots:
            statuses = tuple(self.statuses(root))
            sender = statuses[0].sender
            if self._last_of_sender.get(sender) == root:
                del self._last_of_sender[sender]
            for status in statuses:
                del self._machine.nodes[status.id]
            effects.append(Ended(root, statuses))
        self._machine.ended_roots.clear()
        return effects

    def _resume(self, node: Node) -> list[Effect]:
        if not node.is_handling:
            return []
        module, incarnation = node.handler or "", node.incarnation or ""
        effects: list[Effect] = [Dispatch(node.id, node.attempt, module, incarnation)]
        if not node.is_alive and node.failure is not None:
            reason = node.failure.text
            effects.append(Cancel(node.id, node.attempt, module, incarnation, reason))
        return effects

    def _status(self, node: Node) -> TaskStatus:
        return node.status(waiting_for(node, self._machine.nodes, self._pools))


def _concerns(
    event: Released | Dispatched | Taken | Reported | HandlerLost | HandlerMissing, node: Node
) -> bool:
    match event:
        case Released():
            return node.waits_for(event.previous, event.point)
        case Dispatched() | HandlerMissing():
            return node.is_ready
        case Taken() if node.taken:
            return False
        case _:
            return node.is_handling and node.attempt == event.attempt


def _patience(node: Node) -> float | None:
    """How long a node waits for a module: without bound only when it is handled again."""
    if node.attempt > 0:
        return None
    return node.task.wait_for_handler or LOST_PROVIDER_WAIT


def _dispatch(event: Dispatched) -> Dispatch:
    return Dispatch(event.id, event.attempt, event.module, event.incarnation)
