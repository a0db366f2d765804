"""Records what is decided about requests: by a search, and after a step that came to nothing."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from rogue.explain import Chronicle, Concern, Decision, DecisionKind
from rogue.memory import Hold, Store
from rogue.messages import DeliveryRequest
from rogue.outcomes import Trouble
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


def put_off(holds: Iterable[Hold], now: float) -> list[Decision]:
    """That errands wait, and until when."""
    return [
        Decision(
            time=now,
            kind=DecisionKind.POSTPONED,
            requests=(hold.request,),
            reason=hold.reason,
            until=hold.until,
        )
        for hold in holds
    ]


def taken_up(
    request_ids: Iterable[str], room: str, troubles: Collection[Trouble], now: float
) -> list[Decision]:
    """That errands need not wait any more, for what was the matter at a room is over."""
    requests = tuple(request_ids)
    if not requests:
        return []
    is_open = Trouble.BLOCKED in troubles
    reason = f"the way to {room} is free again" if is_open else f"somebody is in {room} again"
    return [Decision(time=now, kind=DecisionKind.RESUMED, requests=requests, reason=reason)]


def moved(requests: Iterable[DeliveryRequest], now: float) -> list[Decision]:
    """That errands go on in other rooms than were asked for."""
    return [
        Decision(
            time=now,
            kind=DecisionKind.MOVED,
            requests=(one.id,),
            reason=f"from {one.pickup} to {one.destination}",
        )
        for one in requests
    ]
