"""Belief and intention as drawings: cells by their weight, doubt, the way and the goal."""

from __future__ import annotations

import math
from collections import defaultdict

from navigate.maps import CENTIMETRES, Point
from navigate.messages import BeliefState, Outlook
from navigate.view._ink import Pane, Window, polar

FAINTEST, STRONGEST = 0.12, 0.8

TARGET = 0.6
"""Metres from the goal within which belief counts as being there."""


def draw_cells(pane: Pane, belief: BeliefState) -> None:
    """Each square metre by the share of belief in it, each heading by a stroke."""
    masses: defaultdict[Point, float] = defaultdict(float)
    for cell in belief.cells:
        masses[math.floor(cell.x), math.floor(cell.y)] += cell.mass
    for (x, y), mass in masses.items():
        pane.box("cell", Window(x, y, x + 1.0, y + 1.0), opacity=opacity(mass))
    for cell in belief.cells:
        at = (cell.x, cell.y)
        pane.line("look", [at, polar(at, cell.theta, 0.45)], opacity=opacity(cell.mass))


def opacity(mass: float) -> float:
    """How strongly to draw a share of belief: small ones can still be seen."""
    return FAINTEST + (STRONGEST - FAINTEST) * math.sqrt(min(1.0, mass))


def draw_doubt(pane: Pane, belief: BeliefState) -> None:
    """Two standard deviations of the position, where they show beyond the robot."""
    position = belief.position
    pane.disc("doubt", (position.x, position.y), 2.0 * position.deviation)


def draw_way(pane: Pane, outlook: Outlook) -> None:
    """What is in the way, the points yet to pass, and the goal."""
    for spot in outlook.blocked:
        pane.disc("blocked", spot, 0.5)
    position = outlook.belief.position
    if outlook.way:
        pane.line("way", [(position.x, position.y), *outlook.way])
    if outlook.drive is not None:
        goal = (outlook.drive.x / CENTIMETRES, outlook.drive.y / CENTIMETRES)
        pane.disc("goal", goal, max(TARGET, 7.0 / pane.scale))
        pane.disc("goal-dot", goal, 2.5 / pane.scale)
