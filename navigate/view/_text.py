"""What the navigator believes and wants, as text for a terminal."""

from __future__ import annotations

import math
from itertools import pairwise

from navigate.maps import CENTIMETRES, Floor
from navigate.messages import Outlook
from navigate.view._braille import Braille
from navigate.view._floor import extent
from navigate.view._ink import Window, polar
from navigate.view._words import of_navigator, of_world
from xavier_sim.messages import SONAR_COUNT, SONAR_RING_RADIUS, FloorPlan, WorldView

ARROWS = "→↗↑↖←↙↓↘"
SHADES = "░▒▓"
GOAL, REALLY = "◎", "×"

LEAST = 0.02
"""Shares of belief below this are left out."""

SIGHT = 14.0
"""Metres from bottom to top in the closer look."""

FACTS = 5
"""Lines beneath the drawing."""


def draw_text(
    outlook: Outlook, plan: FloorPlan, world: WorldView | None, *, columns: int, rows: int
) -> str:
    """Return the whole floor, a closer look at the robot, and what there is to say.

    The robot is an arrow, its goal a target; shades are belief, dots walls, echoes and the way. A
    cross is where it really stands, if a simulator tells that.

    Args:
        outlook: of the navigator.
        plan: its map.
        world: how things really stand, if anybody knows.
        columns: characters across, at least 40.
        rows: lines, at least 12.
    """
    floor, tall = Floor(plan), rows - FACTS
    whole, position = extent(floor), outlook.belief.position
    strip = min(columns // 2, max(8, math.ceil(2 * tall * whole.width / whole.height)))
    wide = columns - strip - 2
    close = Window.about((position.x, position.y), SIGHT * wide / (2 * tall), SIGHT)
    far, near = Braille(whole, strip, tall), Braille(close, wide, tall)
    for page in (far, near):
        _fill(page, floor, outlook, world)
    _hear(near, outlook)
    beside = [
        f"{one}  {other}".rstrip() for one, other in zip(far.lines(), near.lines(), strict=True)
    ]
    words = of_navigator(outlook) + (of_world(world, position) if world else [])
    return "\n".join([*beside, "", *words])


def _fill(page: Braille, floor: Floor, outlook: Outlook, world: WorldView | None) -> None:
    position = outlook.belief.position
    for x0, y0, x1, y1 in floor.walls.tolist():
        page.line((x0, y0), (x1, y1))
    stops = [(position.x, position.y), *outlook.way]
    for one, other in pairwise(stops):
        page.line(one, other)
    for cell in reversed(outlook.belief.cells):
        if cell.mass >= LEAST:
            page.sign((cell.x, cell.y), SHADES[min(2, int(3 * cell.mass))])
    if outlook.drive is not None:
        page.sign((outlook.drive.x / CENTIMETRES, outlook.drive.y / CENTIMETRES), GOAL)
    if world is not None:
        page.sign((world.robot.x, world.robot.y), REALLY)
    eighth = round(position.theta / (math.pi / 4)) % 8
    page.sign((position.x, position.y), ARROWS[eighth])


def _hear(page: Braille, outlook: Outlook) -> None:
    position = outlook.belief.position
    for number, reading in enumerate(outlook.sonar):
        if reading is not None:
            look = position.theta + math.tau * number / SONAR_COUNT
            for turn in (-0.15, -0.05, 0.05, 0.15):
                page.dot(polar((position.x, position.y), look + turn, SONAR_RING_RADIUS + reading))
