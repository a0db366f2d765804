"""What modules and central say to each other about resources.

A module asks for a *hold* on resources and gets an acknowledgement; central broadcasts what
becomes of it. A hold is a lease of things in the world (a lift, a door), or a reservation or lock
of one resource. Each of these may be sent again without harm: holds are told apart by their id.

A thing in the world has a plain name. The resource of a module's handlers is ``MODULE/NAME``, the
one above all its handlers ``MODULE/``.
"""

from __future__ import annotations

import enum
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from tca_bus._failure import Failure
from tca_bus._messages import Broadcast, Query
from tca_bus._orders import TASK_ID_PATTERN

_CHUNK = "[A-Za-z0-9][A-Za-z0-9._-]{0,99}"

ThingName = Annotated[str, StringConstraints(pattern=rf"^{_CHUNK}$")]
"""The name of a thing in the world."""

ResourceName = Annotated[str, StringConstraints(pattern=rf"^{_CHUNK}(/({_CHUNK})?)?$")]
"""The name of any resource."""

HoldId = Annotated[str, StringConstraints(pattern=TASK_ID_PATTERN)]

MOST_NAMES = 100
"""Resources that one lease may be of."""

MOST_CHECKED = 10_000
"""Holds that one question may be about."""


class HoldKind(enum.StrEnum):
    """What a hold keeps others from."""

    LEASE = "lease"
    """It has one place of each of its resources."""
    RESERVATION = "reservation"
    """Only one module's messages and leases pass."""
    LOCK = "lock"
    """Nobody's messages and leases pass."""


class HoldState(enum.StrEnum):
    """How far a hold is."""

    WAITING = "waiting"
    HELD = "held"
    ENDED = "ended"


class HoldStatus(BaseModel):
    """A hold as central sees it.

    ``sequence`` grows with each change: of two statuses the higher one is newer. ``failure`` says
    why it ended when its holder did not release it. ``module`` is who asked for it, ``passes``
    whose messages a reservation lets through. Times are those of central's clock, seconds since
    the epoch.
    """

    model_config = ConfigDict(frozen=True)

    id: str
    kind: HoldKind
    names: tuple[str, ...]
    module: str
    task: str | None = None
    passes: str | None = None
    priority: int = 0
    state: HoldState
    asked: float
    granted: float | None = None
    ended: float | None = None
    failure: Failure | None = None
    waiting_for: str | None = None
    sequence: int


class AcquireResources(Query[HoldStatus]):
    """Module to central: let me hold these. Sent twice it is one hold.

    The hold ends with ``incarnation`` of the sender; with ``task``, whose try ``attempt`` is being
    handled, at the end of that; an operator's, which names neither, when it is unlocked.
    ``holding`` are the holds that are kept for as long as this one is waited for.

    Refused with ``deadlock`` when it would wait for itself.
    """

    wire_name = "tca.acquire"

    id: HoldId
    kind: HoldKind = HoldKind.LEASE
    names: tuple[ResourceName, ...] = Field(min_length=1, max_length=MOST_NAMES)
    incarnation: str | None = None
    task: str | None = None
    attempt: int = 0
    passes: ThingName | None = None
    priority: int = 0
    holding: tuple[HoldId, ...] = Field(default=(), max_length=MOST_NAMES)


class ReleaseResources(Query[HoldStatus | None]):
    """Module to central: end a hold, or stop waiting for it."""

    wire_name = "tca.release"

    id: HoldId


class CheckHolds(Query[list[HoldStatus]]):
    """Module to central: what became of these; the unknown ones are left out."""

    wire_name = "tca.holds"

    ids: tuple[HoldId, ...] = Field(max_length=MOST_CHECKED)


class UnlockResource(Query[list[HoldStatus]]):
    """Anybody to central: end the lock or reservation of a resource, or else all its leases."""

    wire_name = "tca.unlock"

    name: ResourceName


class DeclareResource(Query[None]):
    """Anybody to central: a thing of this name has so many places.

    At most ``pending`` wait for it: the oldest of the lowest priority is dropped. One that is not
    declared has one place and no limit; what is declared last holds.
    """

    wire_name = "tca.declareResource"

    name: ThingName
    capacity: int = Field(default=1, ge=1)
    pending: int | None = Field(default=None, ge=1)


class ResourceUser(BaseModel):
    """Who holds a resource or waits for it: a hold, or a task at a handler.

    ``since`` is in seconds since the epoch. ``waiting_for`` is None for a holder.
    """

    model_config = ConfigDict(frozen=True)

    id: str
    kind: str
    module: str
    task: str | None = None
    priority: int = 0
    since: float
    waiting_for: str | None = None


class ResourceStatus(BaseModel):
    """A resource, who has it and who waits.

    ``kind`` is ``thing`` for one in the world, ``handlers`` for that of a module. ``dropped``
    counts those that its limit ``pending`` turned away. ``cycles`` are the rings of holds and
    tasks, as sentences, that wait for each other here.
    """

    model_config = ConfigDict(frozen=True)

    name: str
    kind: str
    capacity: int | None
    pending: int | None
    messages: tuple[str, ...] = ()
    holders: list[ResourceUser]
    waiters: list[ResourceUser]
    dropped: int = 0
    cycles: list[str] = []


class ListResources(Query[list[ResourceStatus]]):
    """Anybody to central: all resources, who holds them and who waits."""

    wire_name = "tca.resources"


class HoldChanged(Broadcast):
    """What became of a hold; central repeats none, those concerned ask again every few seconds."""

    wire_name = "tca.hold"

    status: HoldStatus
