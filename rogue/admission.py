"""Which of the open requests take part in the search.

A search over hundreds of errands would be slow to plan and slower to react, and most of them are
far from their turn. So only the most urgent take part, and those that cost nothing beside them;
the others wait, and enter as soon as there is a place for them or they have become urgent enough.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable

from rogue.messages import DeliveryRequest
from rogue.outcomes import Thing

MOST = 12
"""Requests that take part for their urgency."""

MOST_ALONG = 4
"""Requests that take part besides because they begin and end where the others do."""

STAYING = 1.0
"""Priority by which another must be more urgent to take the place of one that was begun."""


def servable(
    requests: Iterable[DeliveryRequest],
    *,
    waits: Callable[[DeliveryRequest], object],
    tray: Collection[Thing],
    places: int | None,
) -> list[DeliveryRequest]:
    """Return the requests that can be gone on with before something changes.

    An errand that is put off waits. Where what is put off leaves no place on the tray, those
    whose items are not on it wait as well.

    Args:
        requests: All that are open.
        waits: Whether a request is put off.
        tray: What is on the tray, as user and item.
        places: Items for which the tray has room, None for any number.
    """
    listed = list(requests)
    free = [request for request in listed if not waits(request)]
    if places is None or len(free) == len(listed):
        return free
    staying = set(tray) - {(request.user, request.item) for request in free}
    held = staying & {(request.user, request.item) for request in listed}
    if not held or len(staying) < places:
        return free
    return [request for request in free if (request.user, request.item) in tray]


def choose(
    requests: Iterable[DeliveryRequest],
    *,
    begun: Collection[str],
    pinned: Collection[str],
    priority: Callable[[DeliveryRequest], float],
    identity: Callable[[DeliveryRequest], Hashable],
    most: int = MOST,
) -> list[DeliveryRequest]:
    """Choose the requests that take part, the most urgent first.

    What is asked for is all on disk, so that an agent which is started again chooses the same.

    Args:
        requests: All that could, the oldest first.
        begun: Ids of those for which something was done.
        pinned: Ids of those that must, since their items are on the tray.
        priority: How urgent a request is.
        identity: Of two requests that the planner cannot tell apart only one takes part.
        most: How many take part for their urgency.
    """

    def urgency(request: DeliveryRequest) -> tuple[bool, float, float]:
        staying = STAYING if request.id in begun else 0.0
        return (request.id not in pinned, -priority(request) - staying, request.deadline)

    distinct: dict[Hashable, DeliveryRequest] = {}
    # What was begun is asked first, so that none like it drives it out.
    for request in sorted(requests, key=lambda r: r.id not in begun):
        distinct.setdefault(identity(request), request)
    ranked = sorted(distinct.values(), key=urgency)
    chosen = [r for at, r in enumerate(ranked) if at < most or r.id in pinned]
    rooms = {room for request in chosen for room in (request.pickup, request.destination)}
    along = [r for r in ranked if r not in chosen and {r.pickup, r.destination} <= rooms]
    return chosen + along[:MOST_ALONG]
