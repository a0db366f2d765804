"""What a map must fulfil beyond the types of its fields: each thing wrong as a sentence."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable
from itertools import combinations

from navigate.maps._door_checks import check_doors, check_gaps
from navigate.maps._floor import inset, is_room
from navigate.maps._place_checks import ROBOT_WIDTH, check_places, check_room, check_start
from navigate.maps._problems import SLACK, problem
from navigate.maps._walls import map_passages
from xavier_sim.messages import FloorPlan, Space

FARTHEST = 10_000.0
"""No corner of a space is farther from 0 than this along an axis, metres."""

MOST_AREA = 100_000.0
"""Square metres of the rectangle round all spaces: what is expected to be heard and seen on a floor
is kept for every ten centimetres of it."""

LEAST_SPACE = 0.7
"""Metres along the shorter side of a space below which no robot stands in it."""


def check_plan(plan: FloorPlan) -> list[str]:
    """List what is wrong with a plan beyond the types of its fields; empty when it is sound."""
    spaces = {space.name: space for space in plan.spaces}
    problems = [
        *_check_names(plan),
        *_check_sizes(plan),
        *_check_overlaps(plan.spaces),
        *check_doors(plan.doors, spaces),
        *check_places(plan, spaces),
        *check_start(plan),
    ]
    return problems or [
        *check_gaps(plan.doors, spaces),
        *check_room(plan),
        *_check_ways(plan),
    ]


def _check_names(plan: FloorPlan) -> list[str]:
    problems = []
    for kind, names in (
        ("space", [space.name for space in plan.spaces]),
        ("door", [door.name for door in plan.doors]),
    ):
        twice = sorted({name for name in names if names.count(name) > 1})
        expected = "a name that is used only once"
        problems += [problem(f"name of a {kind}", name, expected) for name in twice]
    return problems if plan.spaces else [problem("number of spaces", 0, "1 or more")]


def _check_sizes(plan: FloorPlan) -> list[str]:
    far = [
        problem(f"corner of space {space.name!r}", f"{away:g} m from 0", f"{FARTHEST:g} m at most")
        for space in plan.spaces
        if (away := _farthest(space)) > FARTHEST
    ]
    return (far or _check_extent(plan)) + [
        problem(
            f"extent of space {space.name!r} in {axis} ({low:g} to {high:g})",
            f"{high - low:g}",
            f"{LEAST_SPACE} m or more",
        )
        for space in plan.spaces
        for axis, low, high in (
            ("x", space.low.x, space.high.x),
            ("y", space.low.y, space.high.y),
        )
        if high - low < LEAST_SPACE
    ]


def _check_extent(plan: FloorPlan) -> list[str]:
    lows, highs = [space.low for space in plan.spaces], [space.high for space in plan.spaces]
    wide = max((at.x for at in highs), default=0.0) - min((at.x for at in lows), default=0.0)
    tall = max((at.y for at in highs), default=0.0) - min((at.y for at in lows), default=0.0)
    if wide * tall <= MOST_AREA:
        return []
    return [problem("extent of the floor", f"{wide:g} m x {tall:g} m", f"{MOST_AREA:g} m² at most")]


def _farthest(space: Space) -> float:
    return max(abs(one) for at in (space.low, space.high) for one in (at.x, at.y))


def _check_overlaps(spaces: Iterable[Space]) -> list[str]:
    """Walls that cross: open floor may lie over open floor, but nothing over a room."""
    problems = []
    for one, other in combinations(spaces, 2):
        wide = min(one.high.x, other.high.x) - max(one.low.x, other.low.x)
        high = min(one.high.y, other.high.y) - max(one.low.y, other.low.y)
        if min(wide, high) > SLACK and (is_room(one) or is_room(other)):
            item = f"overlap of spaces {one.name!r} and {other.name!r}"
            expected = f"walls that do not cross by more than {SLACK} m"
            problems.append(problem(item, f"{wide:.2f} m x {high:.2f} m", expected))
    return problems


def _check_ways(plan: FloorPlan) -> list[str]:
    """Spaces to which neither doors nor open floor lead from the start."""
    ways = defaultdict[str, set[str]](set)
    for passage in map_passages(plan):
        if passage.door and passage.width <= ROBOT_WIDTH:
            continue
        one, other = passage.spaces
        ways[one].add(other)
        ways[other].add(one)
    x, y = plan.start.x, plan.start.y
    start = next(space.name for space in plan.spaces if inset(space, x, y) >= 0.0)
    reached, ahead = {start}, deque([start])
    while ahead:
        new = ways[ahead.popleft()] - reached
        reached |= new
        ahead.extend(sorted(new))
    cut_off = [space.name for space in plan.spaces if space.name not in reached]
    expected = f"a door wider than {ROBOT_WIDTH} m, or open floor, on the way from {start!r}"
    return [problem(f"way to {name!r}", "none", expected) for name in cut_off]
