"""What a map must fulfil beyond the types of its fields: each thing wrong as a sentence."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable
from itertools import combinations

from navigate.maps._walls import doorway, map_passages
from tca_bus import did_you_mean
from xavier_sim.messages import Corner, Door, FloorPlan, Space, SpaceKind

SLACK = 0.3
"""Metres by which what was surveyed may be off: more is no error of measuring."""

FARTHEST = 10_000.0
"""No corner of a space is farther from 0 than this along an axis, metres."""

MOST_AREA = 100_000.0
"""Square metres of the rectangle round all spaces: what is expected to be heard and seen on a floor
is kept for every ten centimetres of it."""

LEAST_DOOR = 0.61
"""Metres of the robot's width: it passes no door that is as narrow."""

LEAST_SPACE = 0.7
"""Metres along the shorter side of a space below which no robot stands in it."""


def check_plan(plan: FloorPlan) -> list[str]:
    """List what is wrong with a plan beyond the types of its fields; empty when it is sound."""
    spaces = {space.name: space for space in plan.spaces}
    problems = [
        *_check_names(plan),
        *_check_sizes(plan),
        *_check_overlaps(plan.spaces),
        *_check_doors(plan, spaces),
        *_check_places(plan, spaces),
        *_check_start(plan),
    ]
    return problems or _check_ways(plan)


def contains(space: Space, point: Corner, *, slack: float = 0.0) -> bool:
    """Whether ``point`` lies in the rectangle of ``space``, give or take ``slack`` metres."""
    return (
        space.low.x - slack <= point.x <= space.high.x + slack
        and space.low.y - slack <= point.y <= space.high.y + slack
    )


def _check_names(plan: FloorPlan) -> list[str]:
    problems = []
    for kind, names in (
        ("space", [space.name for space in plan.spaces]),
        ("door", [door.name for door in plan.doors]),
    ):
        twice = sorted({name for name in names if names.count(name) > 1})
        problems += [f"{kind} {name!r} is there more than once" for name in twice]
    return problems if plan.spaces else ["there are no spaces"]


def _check_sizes(plan: FloorPlan) -> list[str]:
    far = [
        f"space {space.name!r} reaches {_farthest(space):g} m from 0, expected {FARTHEST:g} at most"
        for space in plan.spaces
        if _farthest(space) > FARTHEST
    ]
    return (far or _check_extent(plan)) + [
        f"space {space.name!r}: low must lie below and left of high, and be {LEAST_SPACE} m away "
        "or more"
        for space in plan.spaces
        if min(space.high.x - space.low.x, space.high.y - space.low.y) < LEAST_SPACE
    ]


def _check_extent(plan: FloorPlan) -> list[str]:
    lows, highs = [space.low for space in plan.spaces], [space.high for space in plan.spaces]
    wide = max((at.x for at in highs), default=0.0) - min((at.x for at in lows), default=0.0)
    tall = max((at.y for at in highs), default=0.0) - min((at.y for at in lows), default=0.0)
    if wide * tall <= MOST_AREA:
        return []
    return [f"the floor spans {wide:g} m x {tall:g} m, expected {MOST_AREA:g} m² at most"]


def _farthest(space: Space) -> float:
    return max(abs(one) for at in (space.low, space.high) for one in (at.x, at.y))


def _check_overlaps(spaces: Iterable[Space]) -> list[str]:
    """Walls that cross: open floor may lie over open floor, but nothing over a room."""
    problems = []
    for one, other in combinations(spaces, 2):
        wide = min(one.high.x, other.high.x) - max(one.low.x, other.low.x)
        high = min(one.high.y, other.high.y) - max(one.low.y, other.low.y)
        if min(wide, high) > SLACK and SpaceKind.ROOM in {one.kind, other.kind}:
            problems.append(
                f"the walls of {one.name!r} and {other.name!r} cross: the two overlap by "
                f"{wide:.2f} m x {high:.2f} m"
            )
    return problems


def _check_doors(plan: FloorPlan, spaces: dict[str, Space]) -> list[str]:
    problems = []
    for door in plan.doors:
        one, other = door.between
        unknown = [name for name in door.between if name not in spaces]
        problems += [
            f"door {door.name!r} leads to unknown space {name!r}.{did_you_mean(name, spaces)}"
            for name in unknown
        ]
        if one == other:
            problems.append(f"door {door.name!r} leads from {one!r} to itself")
        elif not unknown and not all(
            contains(spaces[name], door.at, slack=SLACK) for name in door.between
        ):
            problems.append(f"door {door.name!r} is in no wall between {one!r} and {other!r}")
        elif not unknown and not _fits_wall(door, spaces):
            problems.append(
                f"door {door.name!r}, {door.width:g} m wide, reaches beyond the wall "
                f"between {one!r} and {other!r}"
            )
    return problems


def _fits_wall(door: Door, spaces: dict[str, Space]) -> bool:
    """Whether both ends of a door are where both of its spaces are."""
    ends = (Corner(x=x, y=y) for x, y in doorway(door, spaces).jambs)
    return all(contains(spaces[name], end, slack=SLACK) for end in ends for name in door.between)


def _check_places(plan: FloorPlan, spaces: dict[str, Space]) -> list[str]:
    problems = []
    for room, point in plan.places.items():
        if room not in spaces:
            problems.append(f"place {room!r} is in no space.{did_you_mean(room, spaces)}")
        elif not contains(spaces[room], point, slack=SLACK):
            problems.append(f"the place of {room!r} lies outside of it")
    return problems


def _check_start(plan: FloorPlan) -> list[str]:
    if any(contains(space, plan.start) for space in plan.spaces):
        return []
    return [f"start ({plan.start.x:g}, {plan.start.y:g}) lies in no space"]


def _check_ways(plan: FloorPlan) -> list[str]:
    """Spaces to which neither doors nor open floor lead from the start."""
    ways = defaultdict[str, set[str]](set)
    for passage in map_passages(plan):
        if passage.door and passage.width <= LEAST_DOOR:
            continue
        one, other = passage.spaces
        ways[one].add(other)
        ways[other].add(one)
    start = next(space.name for space in plan.spaces if contains(space, plan.start))
    reached, ahead = {start}, deque([start])
    while ahead:
        new = ways[ahead.popleft()] - reached
        reached |= new
        ahead.extend(sorted(new))
    cut_off = [space.name for space in plan.spaces if space.name not in reached]
    return [
        f"nobody can reach {name!r} from {start!r}: no door that it fits through leads there"
        for name in cut_off
    ]
