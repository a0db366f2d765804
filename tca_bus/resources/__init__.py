"""Holds on resources: leases of things in the world, reservations and locks. Pure.

TCA's resources (``tca.md`` 3.11) are those of handlers; what can be held of them here is a
reservation or a lock. Leases of things are new: TCA had none.
"""

from tca_bus.resources._events import (
    KINDS,
    Asked,
    Declared,
    Finished,
    Granted,
    ResourceEvent,
    decode_resource_event,
    encode_resource_event,
    resource_event_words,
)
from tca_bus.resources._hold import HANDLERS, Hold
from tca_bus.resources._ledger import Changes, Ledger
from tca_bus.resources._tasks import NoTasks, Tasks
from tca_bus.resources._waits import Clause, Member, find_ring

__all__ = [
    "HANDLERS",
    "KINDS",
    "Asked",
    "Changes",
    "Clause",
    "Declared",
    "Finished",
    "Granted",
    "Hold",
    "Ledger",
    "Member",
    "NoTasks",
    "ResourceEvent",
    "Tasks",
    "decode_resource_event",
    "encode_resource_event",
    "find_ring",
    "resource_event_words",
]
