"""Turn what a user asked for into a whole request: fill in, check, rank.

The room of an end is the one that the user names; else the people directory's; else the one of
the user's plan file (Haigh & Veloso 1997, node 5); else the user's answer to a question.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from rogue.deadlines import read_deadline, read_span
from rogue.errors import DuplicateError, SameRoomError, UnknownNameError
from rogue.messages import DeliveryRequest, End, Filled, PostRequest, Refusal, RequestState
from rogue.requests._directory import Directory
from rogue.requests._plan_file import PlanFile
from rogue.requests._rooms import room_in, room_name

ENDS: tuple[End, End] = ("pickup", "deliver")


@dataclass(slots=True)
class Draft:
    """What is known so far of the rooms of a request, and what of them was filled in."""

    rooms: dict[End, str] = field(default_factory=dict)
    filled: list[Filled] = field(default_factory=list)

    @property
    def missing(self) -> list[End]:
        """The ends of which nothing is known."""
        return [end for end in ENDS if end not in self.rooms]

    def fill(self, filled: Filled) -> None:
        """Take in the room of an end, and who knew it."""
        if filled.slot != "deadline":
            self.rooms[filled.slot] = filled.value
            self.filled.append(filled)


def normal(name: str) -> str:
    """A user or item as the directory names it."""
    return name.strip().lower()


def draft(
    message: PostRequest, *, directory: Directory, plan: PlanFile | None, rooms: Collection[str]
) -> Draft:
    """Find the rooms of a request in the message, the directory and the user's plan file.

    Args:
        message: what the user asked for.
        directory: people, items and services.
        plan: what the user's finger server says, if it was asked and knows the user.
        rooms: the rooms of the map.

    Raises:
        UnknownNameError: the user, the item or a room is not known.
    """
    user, item = normal(message.user), normal(message.item)
    found = Draft()
    for end in ENDS:
        named = room_name(message.pickup if end == "pickup" else message.deliver)
        if named is not None:
            found.rooms[end] = checked(end, named, rooms)
        elif usual := directory.usual(end, user, item):
            checked(end, usual.value, rooms, hint=f" Its source is the {usual.source}.")
            found.fill(usual)
        elif planned := plan and _planned(end, item, plan, directory, rooms):
            found.fill(Filled(slot=end, value=planned, source="finger"))
    return found


def accept(
    message: PostRequest,
    drafted: Draft,
    *,
    directory: Directory,
    plan: PlanFile | None = None,
    now: float,
) -> tuple[DeliveryRequest, tuple[Filled, ...]]:
    """The request that ``message`` asks for, and what of it was filled in.

    Args:
        message: what the user asked for.
        drafted: its rooms, both of them.
        directory: people, items and defaults.
        plan: what the user's finger server says, if it was asked and knows the user.
        now: seconds since the epoch, for the deadline.

    Raises:
        RequestError: the rooms are one, or the deadline is no good.
    """
    user, item = normal(message.user), normal(message.item)
    rooms, filled = drafted.rooms, list(drafted.filled)
    if rooms["pickup"] == rooms["deliver"]:
        raise SameRoomError(rooms["pickup"])
    deadline = message.deadline
    if deadline is None or not deadline.strip():
        filled.append(_default_deadline(plan, directory))
        deadline = filled[-1].value
    request = DeliveryRequest(
        id=message.id,
        user=user,
        item=item,
        pickup=rooms["pickup"],
        deliver=rooms["deliver"],
        state=RequestState.QUEUED,
        rank=directory.rank(user, item),
        posted=now,
        deadline=read_deadline(deadline, now),
    )
    return request, tuple(filled)


def checked(end: End, room: str, rooms: Collection[str], *, hint: str = "") -> str:
    """The room, if the map has it.

    Raises:
        UnknownNameError: it has not; ``hint`` ends the sentence.
    """
    if room not in rooms:
        raise UnknownNameError(Refusal.UNKNOWN_ROOM, "room", room, rooms, field=end, hint=hint)
    return room


def is_same_errand(message: PostRequest, known: DeliveryRequest) -> bool:
    """Whether ``message`` is the one that made ``known``, posted once more."""
    return (
        normal(message.user) == known.user
        and normal(message.item) == known.item
        and room_name(message.pickup) in {None, known.pickup}
        and room_name(message.deliver) in {None, known.deliver}
    )


def refuse_duplicate(request: DeliveryRequest, others: Iterable[DeliveryRequest]) -> None:
    """Check that no other open request is for the same errand.

    Raises:
        DuplicateError: one is.
    """
    for other in others:
        if other.closing is None and _errand(other) == _errand(request):
            user, item, pickup, deliver = _errand(request)
            raise DuplicateError(request.id, other.id, f"{item} for {user}, {pickup} to {deliver},")


def _errand(request: DeliveryRequest) -> tuple[str, str, str, str]:
    return request.user, request.item, request.pickup, request.deliver


def _planned(
    end: End, item: str, plan: PlanFile, directory: Directory, rooms: Collection[str]
) -> str | None:
    text = plan.ends.get((end, item))
    if text is None and directory.is_at_user(end, item):
        text = plan.room
    return room_in(text, rooms) if text else None


def _default_deadline(plan: PlanFile | None, directory: Directory) -> Filled:
    if plan and plan.deadline and read_span(plan.deadline):
        return Filled(slot="deadline", value=plan.deadline, source="finger")
    return Filled(slot="deadline", value=directory.defaults.deadline, source="default")
