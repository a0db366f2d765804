"""The task tree: one event in, a list of effects out."""

from __future__ import annotations

from collections import ChainMap, deque
from collections.abc import Iterable
from dataclasses import replace

from tca_bus._attachments import Attachment, Tap
from tca_bus._errors import NoHandlerError, RefusedError
from tca_bus._orders import Order
from tca_bus._protocol import SubmitTask, TaskStatus
from tca_bus._trace_context import child_traceparent, node_context
from tca_bus.tasktree._admission import (
    ROOT,
    check_attachment,
    check_constraints,
    check_order,
    check_parent,
    check_submission,
)
from tca_bus.tasktree._constraints import as_recorded
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
    LAST_SIBLING,
    Abandoned,
    Attached,
    Constrained,
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
from tca_bus.tasktree._feasible import check_together
from tca_bus.tasktree._machine import Machine
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._pools import Pools
from tca_bus.tasktree._registry import Registry
from tca_bus.tasktree._relevance import concerns
from tca_bus.tasktree._waits import AnyOf, waits_of
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
        self._registry = Registry()
        self._last_of_sender: dict[str, str] = {}
        self._tombstones: dict[str, KillRequested] = {}
        self._abandoned: dict[tuple[str, int], Node] = {}
        self._changed: dict[str, None] = {}
        self._is_replaying = False

    def __contains__(self, id: object) -> bool:
        return id in self._machine.nodes

    def __len__(self) -> int:
        return len(self._machine.nodes)

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

    def check(self, task: SubmitTask) -> None:
        """Refuse a submission that cannot become a node. A repeated one is fine.

        Raises:
            RefusedError: the id is taken by another message, the flags contradict each other,
                the parent takes no children, or the node could never start.
            NoHandlerError: nobody handles it and it may not wait.
        """
        check_submission(task, self._machine)
        if self._is_made(task.id):
            return
        check_constraints(task, self._previous(task), self._machine)
        for what in task.attachments:
            check_attachment(what)
        if not task.wait_for_handler and not self._pools.provides(task.name):
            raise NoHandlerError(task.name, self._pools.names())

    def check_prepare(self, id: str, parent: str | None) -> None:
        """Refuse a place that cannot be made.

        Raises:
            RefusedError: the id stands for the root, or the parent takes no children.
        """
        if id == ROOT:
            raise RefusedError(f"task {ROOT!r}", "that id stands for what is above all tasks")
        if parent is not None and id not in self:
            check_parent(id, parent, self._machine)

    def check_order(self, order: Order) -> None:
        """Refuse a constraint that cannot be kept.

        Raises:
            RefusedError: it names the points.
        """
        check_order(order, self._machine.nodes)

    def check_orders(self, orders: Iterable[Order]) -> None:
        """Refuse constraints of which each could be kept, but not all together.

        Raises:
            RefusedError: it names the points that would wait for each other.
        """
        check_together(orders, self._machine.nodes)

    def check_attachment(self, what: Attachment) -> None:
        """Refuse what cannot be attached.

        Raises:
            RefusedError: it says why.
        """
        check_attachment(what)

    def check_kill(self, id: str) -> None:
        """Refuse to kill what is above all tasks.

        Raises:
            RefusedError: the id is that of the root.
        """
        if id == ROOT:
            raise RefusedError("killing the root", "it ends only with central; name a task")

    def holds(self, order: Order) -> bool:
        """Whether a constraint still holds a point back."""
        nodes = self._machine.nodes
        then = nodes.get(order.then.task)
        return then is not None and order.then.point not in then.passed

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
        if id is not None and id not in self:
            raise KeyError(id)
        roots = [id] if id is not None else self.roots()
        return [self._status(node) for root in roots for node in self._machine.below(root)]

    def roots(self) -> list[str]:
        """The ids of the top-level tasks, oldest first."""
        return [node.id for node in self._machine.nodes.values() if node.task.parent is None]

    def root_of(self, id: str) -> str:
        """The id of the top-level task above a node; the id itself when it is unknown."""
        node = self._machine.nodes.get(id)
        return id if node is None else node.root

    def holders(self) -> dict[str, str]:
        """The incarnations that are present, have nodes or attached something, with their names."""
        return {**self._registry.owners(), **self._pools.incarnations()}

    def attachments(self) -> list[Registered | Attached]:
        """What is attached to messages and to nodes that are alive."""
        found: list[Registered | Attached] = list(self._registry)
        for node in self._machine.nodes.values():
            whats: list[Attachment] = [*node.taps.values()]
            whats += [*node.catches.values(), *node.clean_ups.values()]
            own = [what for what in whats if what.id not in self._registry]
            found += [Attached(node.created, node.id, what) for what in own]
        return found

    def taps_on(self, message: str) -> tuple[Tap, ...]:
        """The taps on all messages of a name."""
        return self._registry.taps_of(message)

    def is_missing(self, id: str, number: int) -> bool:
        """Whether the wait for a handler that `WaitForHandler` told of still lasts."""
        return self._pools.is_missing(id, number)

    def is_current(self, id: str, attempt: int) -> bool:
        """Whether a module has this try of the node now."""
        node = self._machine.nodes.get(id)
        return node is not None and node.attempt == attempt and node.is_handling

    def is_awaited(self, id: str, key: str) -> bool:
        """Whether the alarm of the node is still wanted."""
        node = self._machine.nodes.get(id)
        return node is not None and key in node.alarms

    @property
    def pools(self) -> Pools:
        """Who handles what, and who waits for it: to look at, not to change."""
        return self._pools

    def waits(self, id: str) -> list[AnyOf]:
        """What a node waits for, as far as that is certain; see `waits_of`."""
        node = self._machine.nodes.get(id)
        if node is None or self._machine.is_suspended(node):
            return []
        return waits_of(node, self._pools)

    def node(self, id: str) -> Node:
        """The node itself, to look at.

        Raises:
            KeyError: there is no such node.
        """
        return self._machine.nodes[id]

    def _is_made(self, id: str) -> bool:
        node = self._machine.nodes.get(id)
        return node is not None and not node.prepared

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
                self._prepare(event)
            case KillRequested():
                self._kill(event)
            case Registered() | Deregistered():
                self._register(event, events, effects)
            case _:
                self._machine.follow(event)
        if isinstance(event, Dispatched):
            effects.append(_dispatch(event))
        elif isinstance(event, Abandoned):
            self._abandoned[event.id, event.attempt] = self._machine.nodes[event.id]
        self._count()
        return record

    def _happens(self, event: RecordedEvent) -> bool:
        """Whether the event changes anything: those that come twice or too late do not."""
        match event:
            case Submitted():
                check_submission(event.task, self._machine)
                return not self._is_made(event.id)
            case Prepared():
                return event.id not in self
            case KillRequested():
                self.check_kill(event.id)
                node = self._machine.nodes.get(event.id)
                return node is None or bool(node.alive if event.only_below else node.is_alive)
            case Registered():
                return event.id not in self._registry
            case Deregistered():
                return event.id in self._registry
            case Constrained() if not self._is_replaying:
                order = as_recorded(event.order, self._machine.nodes)
                return event.id in self and order is not None
            case _:
                node = self._machine.nodes.get(event.id)
                return node is not None and concerns(event, node)

    def _record(self, event: RecordedEvent) -> Record:
        match event:
            case Submitted():
                return Record(self.root_of(event.task.parent or event.id), event.task.name, event)
            case Prepared():
                return Record(self.root_of(event.parent or event.id), event.name, event)
            case Registered():
                return Record(event.id, event.message, event)
            case _:
                node = self._machine.nodes.get(event.id)
                return Record(self.root_of(event.id), node.task.name if node else "", event)

    def _completed(self, event: RecordedEvent) -> RecordedEvent:
        """The event with what its record has to name: the previous sibling, the taps."""
        if isinstance(event, Prepared):
            return replace(event, taps=event.taps or self._registry.taps_of(event.name))
        if isinstance(event, Constrained) and not self._is_replaying:
            order = as_recorded(event.order, self._machine.nodes)
            return replace(event, order=order or event.order)
        if not isinstance(event, Submitted):
            return event
        if not self._is_replaying:
            event = self._traced(event)
        if not self._is_replaying and event.origin.role is Role.STEP:
            event = self._with_context(event)
        if event.previous != LAST_SIBLING:
            return event
        previous = self._previous(event.task)
        if previous is None:
            return replace(event, previous=None)
        waits = self._machine.nodes[previous].ahead()
        return replace(event, previous=previous, waits=waits)

    def _traced(self, event: Submitted) -> Submitted:
        """The submission in the trace of its parent; one at the root is where it came from."""
        above = self._machine.nodes.get(event.task.parent) if event.task.parent else None
        if above is None:
            return event
        parent = node_context(above.id, above.task.traceparent)
        traceparent = child_traceparent(event.task.traceparent, parent)
        return replace(event, task=event.task.model_copy(update={"traceparent": traceparent}))

    def _with_context(self, event: Submitted) -> Submitted:
        """The submission with the taps on its message, and only those constraints that hold."""
        nodes = self._machine.nodes
        taps = () if event.id in self else self._registry.taps_of(event.task.name)
        if not event.task.orders:
            return replace(event, taps=taps)
        new = {event.id: self._machine.nodes.get(event.id) or Node(event.task, 0.0, event.id)}
        found = [as_recorded(order, ChainMap(new, nodes)) for order in event.task.orders]
        orders = tuple(order for order in found if order is not None)
        return replace(event, taps=taps, task=event.task.model_copy(update={"orders": orders}))

    def _previous(self, task: SubmitTask) -> str | None:
        """The sibling before it that is still there; monitors and taps are passed over."""
        if task.monitor is not None and task.monitor.kind != "point":
            return None
        if task.parent is None:
            previous = self._last_of_sender.get(task.sender)
        else:
            previous = self._machine.nodes[task.parent].last_step
        return previous if previous in self and previous != task.id else None

    def _submit(self, event: Submitted) -> None:
        task = event.task
        if task.parent is None and event.origin.role is Role.STEP:
            self._last_of_sender[task.sender] = task.id
        self._machine.add(event)
        tombstone = self._tombstones.pop(task.id, None)
        if tombstone is not None and event.time - tombstone.time <= TOMBSTONE_SECONDS:
            node = self._machine.nodes[task.id]
            self._machine.kill(event.time, node, tombstone.reason, only_below=False)

    def _prepare(self, event: Prepared) -> None:
        self._machine.prepare(event)

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

    def _status(self, node: Node) -> TaskStatus:
        suspended = not node.has_ended and self._machine.is_suspended(node)
        words = waiting_for(node, self._machine, self._pools, suspended=suspended)
        return node.status(words, suspended=suspended)


def _patience(node: Node) -> float | None:
    """How long a node waits for a module: without bound only when it is handled again."""
    if node.attempt > 0:
        return None
    return node.task.wait_for_handler or LOST_PROVIDER_WAIT


def _dispatch(event: Dispatched) -> Dispatch:
    return Dispatch(event.id, event.attempt, event.module, event.incarnation)
