"""What is recorded of an event: whether it counts, and all that its replay has to know."""

from __future__ import annotations

from collections import ChainMap
from dataclasses import replace

from tca_bus._trace_context import child_traceparent, node_context
from tca_bus.tasktree._admission import check_submission
from tca_bus.tasktree._checks import Checks
from tca_bus.tasktree._constraints import as_recorded
from tca_bus.tasktree._effects import Record
from tca_bus.tasktree._events import (
    LAST_SIBLING,
    Constrained,
    Deregistered,
    KillRequested,
    Prepared,
    RecordedEvent,
    Registered,
    Role,
    Submitted,
)
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._relevance import concerns


class Recording(Checks):
    """Turns an event as it comes into the event as it is recorded.

    A record names what was true at that moment (the sibling before it, the taps on its message, the
    constraints that still held), so that a replay need not find it out again.
    """

    def __init__(self) -> None:
        super().__init__()
        self._is_replaying = False

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
