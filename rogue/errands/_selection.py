"""Which errands are served now: the most urgent, and those that lie on the way.

Source: Haigh & Veloso (1996), Figure 8 and the text above it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rogue.errands._tour import Distance, OpenErrand, Tour, Travel
from rogue.errands._touring import best_tour


@dataclass(frozen=True, slots=True)
class Selected:
    """Keys of the errands that are served now; all others are put off.

    Attributes:
        top: The most urgent ones.
        compatible: Those that the robot can see to on its way without a great detour, and those
            whose items have to leave a full tray.
    """

    top: frozenset[str] = frozenset()
    compatible: frozenset[str] = frozenset()

    def __contains__(self, key: object) -> bool:
        return key in self.top or key in self.compatible


def select(
    errands: Sequence[OpenErrand],
    *,
    start: str | None,
    travel: Travel,
    nearby: float,
    margin: float,
    now: float = 0.0,
) -> Selected:
    """Select the errands that are served now.

    Args:
        errands: All that are open.
        start: Room of the robot, None if it is not known.
        travel: Distances and tray.
        nearby: Metres by which those that are compatible may make the way longer, together.
        margin: How much less urgent than the most urgent one of the top ones may be.
        now: Seconds.
    """
    highest = max((e.rank for e in errands), default=0.0)
    top = [e for e in errands if e.rank >= highest - margin]
    others = [e for e in errands if e.rank < highest - margin]
    if not others:
        return Selected(frozenset(e.key for e in top))
    compatible = _on_the_way(others, _path(top, start, travel, now), travel.distance, nearby)
    if _has_no_room(errands, top, travel):
        compatible += [e.key for e in others if e.carried]
    return Selected(frozenset(e.key for e in top), frozenset(compatible))


def _path(top: Sequence[OpenErrand], start: str | None, travel: Travel, now: float) -> list[str]:
    tour: Tour = best_tour(top, start=start, travel=travel, now=now)
    return [*([start] if start else []), *(stop.room for stop in tour.stops)]


def _on_the_way(
    others: Sequence[OpenErrand], path: list[str], distance: Distance, nearby: float
) -> list[str]:
    """Keys of those whose ends fit into the path; what each costs is taken from ``nearby``."""
    found = []
    for errand in sorted(others, key=lambda e: -e.rank):
        rooms = [errand.deliver] if errand.carried else [errand.pickup, errand.deliver]
        detour, longer = _with_rooms(path, rooms, distance)
        if detour <= nearby:
            nearby -= detour
            path = longer
            found.append(errand.key)
    return found


def _with_rooms(path: list[str], rooms: list[str], distance: Distance) -> tuple[float, list[str]]:
    """The least detour by which a path leads through more rooms in this order, and that path."""
    if not rooms:
        return 0.0, path
    best, found = float("inf"), path
    for at in range(1 if path else 0, len(path) + 1):
        own = _detour(path, at, rooms[0], distance)
        if own < best:
            rest, behind = _with_rooms([rooms[0], *path[at:]], rooms[1:], distance)
            if own + rest < best:
                best, found = own + rest, path[:at] + behind
    return best, found


def _detour(path: list[str], at: int, room: str, distance: Distance) -> float:
    here = path[at - 1] if at else None
    to = distance(here, room) if here else 0.0
    if at == len(path):
        return to
    direct = distance(here, path[at]) if here else 0.0
    return to + distance(room, path[at]) - direct


def _has_no_room(errands: Sequence[OpenErrand], top: Sequence[OpenErrand], travel: Travel) -> bool:
    carried = sum(e.carried for e in errands)
    is_full = travel.capacity is not None and carried >= travel.capacity
    return is_full and not any(e.carried for e in top)
