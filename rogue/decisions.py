"""Records what a search decides about the requests that take part in it."""

from __future__ import annotations

from rogue.explain import Chronicle, Concern
from rogue.memory import Store
from rogue.messages import DeliveryRequest
from rogue.prodigy import Decided, Failed
from tca_bus import Clock


class DecisionRecorder:
    """For one search: who takes part in it, and every decision, into the store."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store = store
        self._clock = clock
        self._chronicle = Chronicle()

    def admit(self, request: DeliveryRequest) -> None:
        """Let a request take part; before the search decides about it."""
        concern = Concern(request.id, request.user, request.item, request.rank, request.posted)
        self._chronicle.admit(concern)

    def withdraw(self, request_id: str) -> None:
        """Let a request take part no more."""
        self._chronicle.withdraw(request_id)

    def see(self, event: Decided | Failed) -> None:
        """Record a decision; it is on disk before the robot acts on it."""
        self._store.record(self._chronicle.note(event, self._clock.now()))
