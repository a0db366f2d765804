"""The robot as a drawing: its body, what its sonars hear, what its panels touch."""

from __future__ import annotations

import math
from collections.abc import Sequence

from navigate.view._ink import Pane, polar
from xavier_sim.messages import (
    BUMP_PANELS,
    SONAR_CONE,
    SONAR_COUNT,
    SONAR_FARTHEST,
    SONAR_RING_RADIUS,
)

RADIUS = 0.305
"""Metres."""

SMALLEST = 5.0
"""Pixels: the robot is never drawn smaller."""

Pose = tuple[float, float, float]
"""x, y in metres and theta in radians."""


def draw_sonar(pane: Pane, pose: Pose, sonar: Sequence[float | None]) -> None:
    """The cones, each as far as it heard nothing, and the echoes at their ends."""
    at, half = (pose[0], pose[1]), SONAR_CONE / 2
    for number, reading in enumerate(sonar):
        look = pose[2] + math.tau * number / SONAR_COUNT
        if reading is None:
            far = SONAR_RING_RADIUS + SONAR_FARTHEST
            pane.line("silent", [polar(at, look, RADIUS), polar(at, look, far)])
        else:
            far = SONAR_RING_RADIUS + reading
            pane.wedge("cone", at, look, half, far)
            pane.arc("echo", at, look, half, far)


def draw_seen(pane: Pane, pose: Pose, seen: Sequence[tuple[float, float]]) -> None:
    """The points that lasers see, given in metres ahead and left."""
    for ahead, left in seen:
        at = polar((pose[0], pose[1]), pose[2] + math.atan2(left, ahead), math.hypot(ahead, left))
        pane.disc("seen", at, 1.8 / pane.scale)


def draw_body(pane: Pane, pose: Pose, bump: int) -> None:
    """A disc that looks somewhere, with the panels that are pressed."""
    at, radius = (pose[0], pose[1]), max(RADIUS, SMALLEST / pane.scale)
    pane.disc("body", at, radius)
    pane.line("nose", [at, polar(at, pose[2], 0.75 * radius)])
    for panel in range(BUMP_PANELS):
        if bump >> panel & 1:
            look = pose[2] + math.tau * panel / BUMP_PANELS
            pane.arc("touch", at, look, math.pi / BUMP_PANELS, radius)
