"""The floor as a drawing: spaces, walls, doors, names of rooms."""

from __future__ import annotations

from collections.abc import Collection

from navigate.maps import Floor, is_room
from navigate.view._ink import Pane, Window
from xavier_sim.messages import Space


def extent(floor: Floor) -> Window:
    """The rectangle that holds the floor, and a metre round it."""
    corners = [corner for space in floor.plan.spaces for corner in (space.low, space.high)]
    return Window.holding(((corner.x, corner.y) for corner in corners), margin=1.0)


def draw_floor(pane: Pane, floor: Floor, shut: Collection[str], *, wall: str) -> None:
    """Spaces, ``wall`` lines, and the doors: gaps, or bars where they are ``shut``."""
    for space in sorted(floor.plan.spaces, key=is_room, reverse=True):
        pane.box("space" if is_room(space) else "open-space", _box(space))
    pane.segments(wall, floor.walls.tolist())
    doors = floor.doors.values()
    pane.segments("leaf", (door.segment() for door in doors if door.name not in shut))
    pane.segments("shut", (door.segment() for door in doors if door.name in shut))


def draw_names(pane: Pane, floor: Floor, goal: str | None) -> None:
    """The names of the rooms, that of the goal set off."""
    for space in filter(is_room, floor.plan.spaces):
        box = _box(space)
        x, y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
        if pane.window.touches(x, y, x, y):
            pane.text("room goal-room" if space.name == goal else "room", (x, y), space.name)


def _box(space: Space) -> Window:
    return Window(space.low.x, space.low.y, space.high.x, space.high.y)
