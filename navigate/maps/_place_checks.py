"""What the places and the start of a map must fulfil: in a space, and the robot fits there."""

from __future__ import annotations

from navigate.maps._floor import clearance_of, inset, is_room
from navigate.maps._problems import SLACK, problem
from navigate.maps._walls import wall_segments
from tca_bus import did_you_mean
from xavier_sim.messages import Corner, FloorPlan, Space

ROBOT_WIDTH = 0.61
"""Metres: the robot passes no door that is as narrow."""

WALL_NEARER = 0.1
"""Metres by which a survey may bring a wall nearer to a place, which keeps its coordinates."""


def check_places(plan: FloorPlan, spaces: dict[str, Space]) -> list[str]:
    """List the places that are in no space of their name, and the rooms that have none."""
    problems = []
    for name, at in plan.places.items():
        if name not in spaces:
            hint = did_you_mean(name, spaces)
            problems.append(problem("name of a place", name, f"the name of a space.{hint}"))
        elif inset(spaces[name], at.x, at.y) < -SLACK:
            problems.append(problem(f"place of {name!r}", _point(at), f"a point inside {name!r}"))
    problems += [
        problem(f"place of {space.name!r}", None, "a point inside the room")
        for space in plan.spaces
        if is_room(space) and space.name not in plan.places
    ]
    return problems


def check_start(plan: FloorPlan) -> list[str]:
    """Tell whether the start is in no space."""
    at = plan.start
    if any(inset(space, at.x, at.y) >= 0.0 for space in plan.spaces):
        return []
    return [problem("start", _point(at), "a point inside a space")]


def check_room(plan: FloorPlan) -> list[str]:
    """List where the robot does not fit though it is to stand there; ``plan`` is sound so far."""
    walls, side = wall_segments(plan), ROBOT_WIDTH / 2.0
    points = {f"place of {name!r}": at for name, at in plan.places.items()} | {"start": plan.start}
    free = {item: clearance_of(walls, at.x, at.y) for item, at in points.items()}
    return [
        problem(
            item,
            _point(at),
            f"a point {side:g} m or more from any wall, not {free[item]:.3g}",
        )
        for item, at in points.items()
        if free[item] < side - WALL_NEARER
    ]


def _point(at: Corner) -> str:
    return f"({at.x:g}, {at.y:g})"
