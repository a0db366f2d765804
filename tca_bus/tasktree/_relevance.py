"""Whether an event still says something of its node: it may come twice, or too late."""

from __future__ import annotations

from tca_bus.tasktree._events import (
    Abandoned,
    Alarmed,
    Attached,
    CaughtFailure,
    Constrained,
    Detached,
    Dispatched,
    HandlerLost,
    HandlerMissing,
    NodeEvent,
    Prioritized,
    Released,
    Reported,
    Resumed,
    Retried,
    Suspended,
    Taken,
    Triggered,
    UncaughtFailure,
)
from tca_bus.tasktree._node import Node, Source


def concerns(event: NodeEvent, node: Node) -> bool:
    """Whether the event changes the node."""
    match event:
        case Released():
            return node.waits_for(Source(event.previous, event.point, event.delay))
        case Dispatched() | HandlerMissing():
            return node.is_ready
        case Taken() if node.taken:
            return False
        case Taken() | Reported() | HandlerLost() | Abandoned():
            return node.is_handling and node.attempt == event.attempt
        case Triggered():
            return _counts(event, node)
        case CaughtFailure() | UncaughtFailure():
            return node.is_alive and node.failing
        case Alarmed():
            return node.is_alive and event.key in node.alarms
        case _:
            return not node.has_ended and _changes(event, node)


def _counts(event: Triggered, node: Node) -> bool:
    watch = node.watch
    current = node.is_handling and node.attempt == event.attempt and node.is_alive
    return current and watch is not None and not watch.expired and event.number > watch.told


def _changes(event: NodeEvent, node: Node) -> bool:
    match event:
        case Suspended():
            return not node.suspended
        case Resumed():
            return node.suspended
        case Prioritized():
            return event.priority != node.priority
        case Retried():
            return node.is_alive and not node.restarting and not node.prepared
        case Attached():
            attached = {**node.taps, **node.catches, **node.clean_ups}
            return event.what.id not in attached
        case Detached():
            return event.attachment in {**node.taps, **node.catches, **node.clean_ups}
        case Constrained():
            return True
        case _:
            return False
