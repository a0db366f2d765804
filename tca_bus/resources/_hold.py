"""One hold: a lease, a reservation or a lock, waiting or held."""

from __future__ import annotations

from dataclasses import dataclass

from tca_bus._failure import Failure
from tca_bus._resource_messages import AcquireResources, HoldKind, HoldState, HoldStatus

Order = tuple[bool, int, int]

HANDLERS = "/"
"""Stands in the name of a handlers' resource, and in no other."""


@dataclass(slots=True, eq=False)
class Hold:
    """What a module asked for. ``serial`` is its place in the order of asking."""

    request: AcquireResources
    module: str
    asked: float
    serial: int
    sequence: int
    granted: float | None = None
    ended: float | None = None
    failure: Failure | None = None

    @property
    def id(self) -> str:
        """The id of the hold."""
        return self.request.id

    @property
    def names(self) -> tuple[str, ...]:
        """What it holds or waits for."""
        return self.request.names

    @property
    def is_lease(self) -> bool:
        """Whether it has places, else it keeps all others out."""
        return self.request.kind is HoldKind.LEASE

    @property
    def passes(self) -> str | None:
        """The module that it lets through."""
        if self.request.kind is HoldKind.RESERVATION:
            return self.request.passes or self.module
        return None

    @property
    def state(self) -> HoldState:
        """How far it is."""
        if self.ended is not None:
            return HoldState.ENDED
        return HoldState.WAITING if self.granted is None else HoldState.HELD

    @property
    def order(self) -> Order:
        """Locks and reservations first, then by priority, then first come first served."""
        return self.is_lease, -self.request.priority if self.is_lease else 0, self.serial

    def words(self) -> str:
        """Who it is, for people."""
        inside = f" in task {self.request.task}" if self.request.task else ""
        if self.is_lease:
            return f"{self.module}{inside}"
        held = "has" if self.granted is not None else "waits for"
        over = f" for {self.passes}" if self.passes not in {None, self.module} else ""
        return f"{self.module}{inside}, who {held} a {self.request.kind}{over}"

    def status(self, waiting_for: str | None) -> HoldStatus:
        """The hold as others see it."""
        return HoldStatus(
            id=self.id,
            kind=self.request.kind,
            names=self.names,
            module=self.module,
            task=self.request.task,
            passes=self.passes,
            priority=self.request.priority,
            state=self.state,
            asked=self.asked,
            granted=self.granted,
            ended=self.ended,
            failure=self.failure,
            waiting_for=waiting_for,
            sequence=self.sequence,
        )
