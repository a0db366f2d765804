"""Turn what a user asked for into a whole request: fill in, check, rank."""

from __future__ import annotations

from collections.abc import Collection

from rogue.deadlines import read_deadline
from rogue.errors import SameRoomError, UnknownNameError
from rogue.messages import DeliveryRequest, PostRequest, Refusal, RequestState
from rogue.requests._directory import Directory


def accept(
    message: PostRequest, *, directory: Directory, rooms: Collection[str], now: float
) -> DeliveryRequest:
    """The request that ``message`` asks for, with the directory's rooms where it names none.

    Args:
        message: what the user asked for.
        directory: people, items and services.
        rooms: the rooms of the map.
        now: seconds since the epoch, for the deadline.

    Raises:
        RequestError: a name is unknown, the rooms are one, or the deadline is no good.
    """
    user, item = message.user.strip().lower(), message.item.strip().lower()
    rank = directory.rank(user, item)
    start, end = directory.ends(user, item)
    pickup = _room(message.pickup, start, rooms)
    deliver = _room(message.deliver, end, rooms)
    if pickup == deliver:
        raise SameRoomError(pickup)
    return DeliveryRequest(
        id=message.id,
        user=user,
        item=item,
        pickup=pickup,
        deliver=deliver,
        state=RequestState.QUEUED,
        rank=rank,
        posted=now,
        deadline=read_deadline(message.deadline, now),
    )


def is_same_errand(message: PostRequest, known: DeliveryRequest) -> bool:
    """Whether ``message`` is the one that made ``known``, posted once more."""
    return (
        message.user.strip().lower() == known.user
        and message.item.strip().lower() == known.item
        and _named(message.pickup) in {None, known.pickup}
        and _named(message.deliver) in {None, known.deliver}
    )


def _room(named: str | None, default: str, rooms: Collection[str]) -> str:
    room = _named(named) or default
    if room not in rooms:
        raise UnknownNameError(Refusal.UNKNOWN_ROOM, "room", room, rooms)
    return room


def _named(room: str | None) -> str | None:
    """A room as the map names it: ``5303`` and ``R-5303`` are ``r-5303``."""
    if room is None or not room.strip():
        return None
    name = room.strip().lower()
    return f"r-{name}" if name.isdigit() else name
