"""What happens to holds: recorded, and replayed after a restart.

Times are seconds since the epoch, by central's clock.
"""

from __future__ import annotations

from dataclasses import dataclass

from tca_bus._event_codec import EventCodec
from tca_bus._failure import Failure
from tca_bus._resource_messages import AcquireResources, HoldKind


@dataclass(frozen=True, slots=True)
class Declared:
    """Somebody said how many places a thing has, and how many may wait for one."""

    time: float
    name: str
    capacity: int
    pending: int | None

    @property
    def subject(self) -> str:
        """What the record belongs to."""
        return f"resource/{self.name}"


@dataclass(frozen=True, slots=True)
class Asked:
    """A module wants to hold resources."""

    time: float
    module: str
    request: AcquireResources

    @property
    def id(self) -> str:
        """The id of the hold."""
        return self.request.id

    @property
    def subject(self) -> str:
        """What the record belongs to."""
        return f"hold/{self.id}"


@dataclass(frozen=True, slots=True)
class Granted:
    """The hold began."""

    time: float
    id: str

    @property
    def subject(self) -> str:
        """What the record belongs to."""
        return f"hold/{self.id}"


@dataclass(frozen=True, slots=True)
class Finished:
    """The hold ended, or is waited for no more; ``failure`` says why if not by its holder."""

    time: float
    id: str
    failure: Failure | None = None

    @property
    def subject(self) -> str:
        """What the record belongs to."""
        return f"hold/{self.id}"


HoldEvent = Asked | Granted | Finished
ResourceEvent = Declared | HoldEvent

_CODEC: EventCodec[ResourceEvent] = EventCodec(
    (Declared, Asked, Granted, Finished), prefix="Resource"
)

KINDS = _CODEC.kinds
"""The kinds of records."""

encode_resource_event = _CODEC.encode
decode_resource_event = _CODEC.decode


def resource_event_words(event: ResourceEvent) -> tuple[str, str]:
    """The word for an event and the sentence that goes with it."""
    match event:
        case Declared():
            limit = f", at most {event.pending} wait" if event.pending else ""
            return "resource declared", f"{event.capacity} at once{limit}"
        case Asked(request=request):
            what = "" if request.kind is HoldKind.LEASE else f"{request.kind} "
            return "resource asked for", f"{what}{', '.join(request.names)} by {event.module}"
        case Granted():
            return "resource held", "it is the holder's turn"
        case Finished():
            why = event.failure.text if event.failure else "by its holder"
            return "resource released", why
