"""The task tree: one event in, a list of effects out."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from tca_bus._attachments import Tap
from tca_bus._protocol import TaskStatus
from tca_bus.tasktree._effects import (
    Cancel,
    Dispatch,
    Effect,
    Ended,
    Freed,
    Publish,
    Record,
    SetAlarm,
    WaitForHandler,
)
from tca_bus.tasktree._events import (
    Abandoned,
    Attached,
    Deregistered,
    Detached,
    Dispatched,
    Event,
    GateChanged,
    HandlerLost,
    KillRequested,
    LimitExceeded,
    Prepared,
    ProviderAppeared,
    ProviderLost,
    RecordedEvent,
    Registered,
    Reported,
    Role,
    Submitted,
)
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._recording import Recording

TOMBSTONE_SECONDS = 60.0
"""How long a kill is remembered that came before its task."""

LOST_PROVIDER_WAIT = 30.0
"""Seconds that an accepted node waits when the last module that handles it went away."""

GENERATION_STEP = 1_000_000
"""Sequence numbers begin here times the generation, so that a restart never goes back."""


class Tree(Recording):
    """All task nodes that are alive, and what they wait for.

    Pure: `apply` changes the tree and returns what is to be done, in order. The `Record`
    effects, replayed in order on a fresh tree, give the same tree.

    Args:
        generation: How often this tree was rebuilt from its records; sequence numbers of a
            later generation are higher than all of an earlier one.
    """

    def __init__(self, *, generation: int = 0) -> None:
        super().__init__()
        self._base = generation * GENERATION_STEP
        self._tombstones: dict[str, KillRequested] = {}
        self._abandoned: dict[tuple[str, int], Node] = {}
        self._changed: dict[str, None] = {}

    def abandoned(self, id: str) -> TaskStatus | None:
        """A task whose handler was not waited for any longer and keeps its place in its module."""
        found = (node for (own, _), node in self._abandoned.items() if own == id)
        node = next(found, None)
        return None if node is None else self._status(node)

    def apply(self, event: Event) -> list[Effect]:
        """Let one event happen; gives the effects in the order in which they are due.

        Raises:
            RefusedError: an event that cannot be, see the ``check`` methods.
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

        That is: `Dispatch` again for every node that a module has (it tells tries apart), and the
        alarms. What ended is in the history: an end and the events behind it are recorded together.
        """
        effects: list[Effect] = []
        self._is_replaying = True
        for event in events:
            self.apply(event)
        self._is_replaying = False
        for node in self._machine.nodes.values():
            node.sequence = max(node.sequence, self._base)
            effects += self._resume(node)
        self._pools.forget_missing()
        self._decide(self._machine.now, deque(), effects)
        return effects

    def _step(self, event: Event, events: deque[Event], effects: list[Effect]) -> Record | None:
        match event:
            case ProviderAppeared():
                self._pools.appear(
                    event.module,
                    event.incarnation,
                    event.capacities,
                    resources=event.resources,
                    limits=event.limits,
                    is_introduced=event.is_introduced,
                )
                return None
            case GateChanged():
                self._pools.set_gate(event.resource, event.gate)
                return None
            case ProviderLost():
                events += self._losses(event)
                return None
            case _:
                return self._step_recorded(event, events, effects)

    def _losses(self, event: ProviderLost) -> list[Event]:
        """What the module had, the deepest first: a parent fails knowing what failed below it."""
        module, ids = self._pools.lose(event.incarnation)
        self._abandoned = {
            key: node
            for key, node in self._abandoned.items()
            if node.incarnation != event.incarnation
        }
        nodes = [self._machine.nodes[id] for id in ids if id in self._machine.nodes]
        nodes.sort(key=lambda node: -len(list(self._machine.ancestors(node))))
        lost: list[Event] = [
            HandlerLost(event.time, node.id, node.attempt, module) for node in nodes
        ]
        lost += [Deregistered(event.time, id) for id in self._registry.owned_by(event.incarnation)]
        unsent = [
            node.id
            for node in self._machine.nodes.values()
            if node.prepared and node.task.sender == event.module
        ]
        why = f"module {event.module!r} was lost before it sent it"
        return lost + [KillRequested(event.time, id, why) for id in unsent]

    def _step_recorded(
        self, event: RecordedEvent, events: deque[Event], effects: list[Effect]
    ) -> Record | None:
        if isinstance(event, Reported):
            self._release_abandoned(event)
        if not self._happens(event):
            return None
        event = self._completed(event)
        record = self._record(event)
        match event:
            case Submitted():
                self._submit(event)
            case Prepared():
                self._machine.prepare(event)
            case KillRequested():
                self._kill(event)
            case Registered() | Deregistered():
                self._register(event, events, effects)
            case _:
                self._machine.follow(event)
        if isinstance(event, Dispatched):
            told = Dispatch(event.id, event.attempt, event.module, event.incarnation)
            effects.append(told)
        elif isinstance(event, Abandoned):
            self._abandoned[event.id, event.attempt] = self._machine.nodes[event.id]
        self._count()
        return record

    def _submit(self, event: Submitted) -> None:
        task = event.task
        if task.parent is None and event.origin.role is Role.STEP:
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

    def _register(
        self,
        event: Registered | Deregistered,
        events: deque[Event],
        effects: list[Effect],
    ) -> None:
        """Taps on a message hold for the nodes of it that are there too."""
        if isinstance(event, Registered):
            self._registry.add(event)
            if isinstance(event.what, Tap) and not self._is_replaying:
                ids = self._tapped_by(event)
                events.extend(Attached(event.time, id, event.what) for id in ids)
            return
        self._registry.remove(event.id)
        effects.append(Ended(event.id, event.time))
        if not self._is_replaying:
            tapped = [n.id for n in self._machine.nodes.values() if event.id in n.taps]
            events.extend(Detached(event.time, id, event.id) for id in tapped)

    def _tapped_by(self, event: Registered) -> list[str]:
        nodes = self._machine.nodes.values()
        return [
            node.id
            for node in nodes
            if node.role is Role.STEP and event.message in {"*", node.task.name}
        ]

    def _release_abandoned(self, event: Reported) -> None:
        """A handler that was waited for no longer has ended after all: its place is free."""
        node = self._abandoned.pop((event.id, event.attempt), None)
        if node is not None:
            self._pools.release(node.id, node.task.name, node.incarnation or "")

    def _decide(self, time: float, events: deque[Event], effects: list[Effect]) -> None:
        """Choose the next handler for a node that is ready; start waits where nobody is there.

        The choice happens before anything else does, since it was made for the tree as it is.
        """
        machine = self._machine
        if not self._is_replaying:
            events.extend(machine.sends)
            searches = dict.fromkeys(machine.searches)
            catches_of = lambda name: list(self._registry.catches_of(name))  # noqa: E731
            events.extend(machine.find_catch(time, id, catches_of) for id in searches)
            events.extend(machine.crossings)
            effects += machine.tells
        for collected in (machine.sends, machine.searches, machine.crossings, machine.tells):
            collected.clear()
        self._assign(time, events)
        for id, number in self._pools.newly_missing():
            seconds = _patience(machine.nodes[id])
            if seconds is not None:
                effects.append(WaitForHandler(id, number, seconds))
        effects += machine.cancels
        effects += machine.alarms
        machine.cancels.clear()
        machine.alarms.clear()

    def _assign(self, time: float, events: deque[Event]) -> None:
        choice = self._pools.assign()
        if choice is not None:
            attempt = self._machine.nodes[choice.id].attempt + 1
            chosen = Dispatched(time, choice.id, attempt, choice.module, choice.incarnation)
            events.appendleft(chosen)
            return
        excess = None if events else self._pools.overflow()
        if excess is not None:
            events.append(LimitExceeded(time, excess.id, excess.resource, excess.limit))

    def _count(self) -> None:
        for id in self._machine.touched:
            node = self._machine.nodes.get(id)
            if node is not None:
                node.sequence = max(node.sequence, self._base) + 1
                self._changed[id] = None
        self._machine.touched.clear()

    def _publish(self) -> list[Effect]:
        changed = [Publish(self.status(id)) for id in self._changed if id in self]
        self._changed.clear()
        return list(changed)

    def _free(self) -> list[Effect]:
        """Free what ended: the history has it."""
        effects: list[Effect] = []
        for node in self._machine.ended:
            self._drop(node)
            effects.append(Freed(node.root, self._status(node)))
        effects += [Ended(root, self._machine.now) for root in self._machine.ended_roots]
        self._machine.ended.clear()
        self._machine.ended_roots.clear()
        return effects

    def _drop(self, node: Node) -> None:
        del self._machine.nodes[node.id]
        sender, parent = node.task.sender, node.task.parent
        if self._last_of_sender.get(sender) == node.id:
            del self._last_of_sender[sender]
        above = self._machine.nodes.get(parent) if parent is not None else None
        if above is not None:
            above.children.pop(node.id, None)

    def _resume(self, node: Node) -> list[Effect]:
        effects: list[Effect] = [
            SetAlarm(node.id, key, when, passive=key == "deadline")
            for key, when in node.alarms.items()
        ]
        if not node.is_handling:
            return effects
        module, incarnation = node.handler or "", node.incarnation or ""
        effects.append(Dispatch(node.id, node.attempt, module, incarnation))
        why = self._why_it_stops(node)
        if why is not None:
            stop = Cancel(node.id, node.attempt, module, incarnation, why, node.task.grace)
            effects.append(stop)
        return effects

    def _why_it_stops(self, node: Node) -> str | None:
        """Why the handler of a node is to stop; None when it is not."""
        if not node.is_alive and node.failure is not None:
            return node.failure.text
        if node.restarting:
            return "it is handled again"
        if node.doomed is not None:
            return node.doomed.text
        return "it expired" if node.watch is not None and node.watch.expired else None


def _patience(node: Node) -> float | None:
    """How long a node waits for a module: without bound only when it is handled again."""
    if node.attempt > 0:
        return None
    return node.task.wait_for_handler or LOST_PROVIDER_WAIT
