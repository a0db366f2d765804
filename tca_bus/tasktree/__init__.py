"""The task tree of TCA as a pure state machine: events in, effects out.

Semantics: Simmons, *Structured control for autonomous robots* (1994); the transitions follow
TCM, in which each point of a node waits for a set of other points and is told of each one.
"""

from tca_bus.tasktree._admission import ROOT, check_same
from tca_bus.tasktree._codec import decode_event, encode_event
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
from tca_bus.tasktree._tree import LOST_PROVIDER_WAIT, TOMBSTONE_SECONDS, Tree

__all__ = [
    "LOST_PROVIDER_WAIT",
    "ROOT",
    "TOMBSTONE_SECONDS",
    "Cancel",
    "Dispatch",
    "Dispatched",
    "Effect",
    "Ended",
    "Event",
    "HandlerLost",
    "HandlerMissing",
    "KillRequested",
    "ProviderAppeared",
    "ProviderLost",
    "Publish",
    "Record",
    "RecordedEvent",
    "Released",
    "Reported",
    "Submitted",
    "Taken",
    "Tree",
    "WaitForHandler",
    "check_same",
    "decode_event",
    "encode_event",
]
