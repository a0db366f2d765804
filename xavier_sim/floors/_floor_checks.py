"""What a floor plan must fulfil beyond its types: names, overlaps, doors, places, ways."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from itertools import combinations

from tca_bus import TcaError, did_you_mean
from xavier_sim.floors._geometry import (
    TOUCH,
    build_geometry,
    contains,
    door_edge,
    segment_distances,
    shared_edges,
    space_at,
)
from xavier_sim.messages import Door, FloorPlan, Space, SpaceKind

ROBOT_WIDTH = 0.61
"""An opening narrower than this leads nowhere for Xavier, metres."""

FARTHEST = 10_000.0
"""No coordinate of a floor is farther from 0 than this, metres."""


class FloorError(TcaError, ValueError):
    """A floor plan is wrong: in which file, which item, what it is, what it should be."""

    exit_code = 2

    def __init__(self, file: str, item: str, value: object, expected: str) -> None:
        self.file, self.item, self.value, self.expected = file, item, value, expected
        super().__init__(f"{file}: {item} is {str(value)[:120]!r}, expected {expected}")


def check_floor(file: str, plan: FloorPlan) -> None:
    """Check a plan as a whole.

    Raises:
        FloorError: the first thing found wrong; ``file`` is only named in it.
    """
    _check_names(file, "space", [space.name for space in plan.spaces])
    _check_names(file, "door", [door.name for door in plan.doors])
    spaces = {space.name: space for space in plan.spaces}
    for door in plan.doors:
        if door.name in spaces:
            raise FloorError(file, "name of a door", door.name, "a name that no space has")
    for space in plan.spaces:
        _check_corners(file, space)
    _check_overlaps(file, plan.spaces)
    for door in plan.doors:
        _check_door(file, door, spaces)
    _check_gaps(file, plan.doors, spaces)
    _check_places(file, plan, spaces)
    _check_charger(file, plan)
    _check_ways(file, plan, spaces)
    _check_fits(file, plan)


def _check_names(file: str, what: str, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise FloorError(file, f"name of a {what}", name, "a name that is used only once")
        seen.add(name)


def _check_corners(file: str, space: Space) -> None:
    for axis in ("x", "y"):
        low, high = getattr(space.low, axis), getattr(space.high, axis)
        for name, value in (("low", low), ("high", high)):
            if abs(value) > FARTHEST:
                item = f"space {space.name}: {name}.{axis}"
                raise FloorError(file, item, f"{value:g}", f"at most {FARTHEST:g} m from 0")
        if high - low < ROBOT_WIDTH:
            item = f"space {space.name}: extent in {axis} ({low:g} to {high:g})"
            raise FloorError(file, item, f"{high - low:g}", f"at least {ROBOT_WIDTH} m")


def _check_overlaps(file: str, spaces: Iterable[Space]) -> None:
    for one, other in combinations(spaces, 2):
        wide = min(one.high.x, other.high.x) - max(one.low.x, other.low.x)
        tall = min(one.high.y, other.high.y) - max(one.low.y, other.low.y)
        if wide > TOUCH and tall > TOUCH:
            item = f"overlap of spaces {one.name} and {other.name}"
            raise FloorError(file, item, f"{wide:.3g} x {tall:.3g} m", "spaces that do not overlap")


def _check_door(file: str, door: Door, spaces: dict[str, Space]) -> None:
    for name in door.between:
        if name not in spaces:
            expected = f"the name of a space.{did_you_mean(name, spaces)}"
            raise FloorError(file, f"door {door.name}: between", name, expected)
    one, other = door.between
    if one == other or not shared_edges(spaces[one], spaces[other]):
        expected = "two spaces that share a wall"
        raise FloorError(file, f"door {door.name}: between", f"{one}, {other}", expected)
    if SpaceKind.ROOM not in {spaces[one].kind, spaces[other].kind}:
        expected = "at least one room: other spaces are open to each other"
        raise FloorError(file, f"door {door.name}: between", f"{one}, {other}", expected)
    if door_edge(door, spaces) is None:
        at = f"({door.at.x:g}, {door.at.y:g})"
        expected = (
            f"a point of the wall that {one} and {other} share, {door.width:g} m wide round it"
        )
        raise FloorError(file, f"door {door.name}: at", at, expected)


def _check_gaps(file: str, doors: Iterable[Door], spaces: dict[str, Space]) -> None:
    """No two doors are in one piece of wall."""
    gaps = [(door, gap) for door in doors if (gap := door_edge(door, spaces)) is not None]
    for (one, gap), (other, hole) in combinations(gaps, 2):
        same_line = gap.axis == hole.axis and abs(gap.at - hole.at) < TOUCH
        if same_line and min(gap.span[1], hole.span[1]) - max(gap.span[0], hole.span[0]) > TOUCH:
            at = f"({other.at.x:g}, {other.at.y:g})"
            raise FloorError(file, f"door {other.name}: at", at, f"a place beside door {one.name}")


def _check_fits(file: str, plan: FloorPlan) -> None:
    """Where the robot is to stand, it can: no wall is nearer than its side."""
    walls = build_geometry(plan).walls
    points = {f"place of {name}": point for name, point in plan.places.items()}
    points |= {"start": plan.start} | ({"charger": plan.charger} if plan.charger else {})
    for item, point in points.items():
        free = segment_distances(walls, point.x, point.y).min(initial=FARTHEST)
        if free < ROBOT_WIDTH / 2.0:
            at = f"({point.x:g}, {point.y:g})"
            expected = f"a point at least {ROBOT_WIDTH / 2.0:g} m from any wall, not {free:.3g} m"
            raise FloorError(file, item, at, expected)


def _check_places(file: str, plan: FloorPlan, spaces: dict[str, Space]) -> None:
    for name, point in plan.places.items():
        if name not in spaces:
            expected = f"the name of a space.{did_you_mean(name, spaces)}"
            raise FloorError(file, "place", name, expected)
        if not contains(spaces[name], point):
            at = f"({point.x:g}, {point.y:g})"
            raise FloorError(file, f"place of {name}", at, f"a point inside {name}")
    for space in plan.spaces:
        if space.kind is SpaceKind.ROOM and space.name not in plan.places:
            raise FloorError(file, f"place of {space.name}", None, "a point inside the room")


def _check_charger(file: str, plan: FloorPlan) -> None:
    at = plan.charger
    if at is not None and space_at(plan, at.x, at.y) is None:
        raise FloorError(file, "charger", f"({at.x:g}, {at.y:g})", "a point inside a space")


def _check_ways(file: str, plan: FloorPlan, spaces: dict[str, Space]) -> None:
    start = space_at(plan, plan.start.x, plan.start.y)
    if start is None:
        at = f"({plan.start.x:g}, {plan.start.y:g})"
        raise FloorError(file, "start", at, "a point inside a space")
    reached = _reachable(plan, spaces, start.name)
    for name in spaces:
        if name not in reached:
            expected = f"a door or opening on the way from {start.name}"
            raise FloorError(file, f"way to {name}", "none", expected)


def _reachable(plan: FloorPlan, spaces: dict[str, Space], start: str) -> set[str]:
    ways: dict[str, set[str]] = {name: set() for name in spaces}
    links = [door.between for door in plan.doors if door.width > ROBOT_WIDTH]
    for one, other in [*links, *_openings(plan)]:
        ways[one].add(other)
        ways[other].add(one)
    reached, queue = {start}, deque([start])
    while queue:
        new = ways[queue.popleft()] - reached
        reached |= new
        queue.extend(sorted(new))
    return reached


def _openings(plan: FloorPlan) -> list[tuple[str, str]]:
    open_spaces = [space for space in plan.spaces if space.kind is not SpaceKind.ROOM]
    return [
        (one.name, other.name)
        for one, other in combinations(open_spaces, 2)
        if any(edge.span[1] - edge.span[0] > ROBOT_WIDTH for edge in shared_edges(one, other))
    ]
