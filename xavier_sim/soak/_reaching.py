"""Whether a robot can get from one space of a floor to another at all, as the doors stand."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from xavier_sim.floors import shared_edges
from xavier_sim.messages import FloorPlan, SpaceKind


class Reach:
    """The spaces of a floor and the ways between them: open floor, and doors by their names."""

    def __init__(self, plan: FloorPlan) -> None:
        self._ways: defaultdict[str, list[tuple[str, str | None]]] = defaultdict(list)
        for door in plan.doors:
            self._join(*door.between, door.name)
        common = [space for space in plan.spaces if space.kind is not SpaceKind.ROOM]
        for index, one in enumerate(common):
            for other in common[index + 1 :]:
                if shared_edges(one, other):
                    self._join(one.name, other.name, None)

    def reachable(self, start: str, goal: str, is_open: Mapping[str, bool]) -> bool:
        """Whether there is a way from one space to another through doors that are open."""
        seen, ahead = {start}, [start]
        while ahead:
            here = ahead.pop()
            if here == goal:
                return True
            for other, door in self._ways[here]:
                if other not in seen and (door is None or is_open[door]):
                    seen.add(other)
                    ahead.append(other)
        return False

    def _join(self, one: str, other: str, door: str | None) -> None:
        self._ways[one].append((other, door))
        self._ways[other].append((one, door))
