"""Arcs among obstacles: which curvatures are blocked, and how far one can drive along the others.

Frame: x ahead, y to the left, curvature c = turn rate / speed, positive to the left. An obstacle
circle (x, y) of radius r, inflated by the robot, blocks exactly the curvatures between
2 (y - r) / (x^2 + y^2 - r^2) and 2 (y + r) / (x^2 + y^2 - r^2).
After Simmons, The Curvature-Velocity Method for Local Obstacle Avoidance, ICRA 1996, section 3,
with these bounds derived anew.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navigate.maps import Floats

SHARPEST = 100.0
"""Curvature, per metre, that stands for turning on the spot."""

FAR = 1e6
"""Metres that stand for a way without end."""

NEARLY_BEHIND = 3.1
"""Radians aside beyond which an arc to a point goes round nearly a whole circle."""

MOST_CIRCLES = 32
"""Circles that are looked at, those first that are met first."""

SLIT = 1e-6
"""Width of an interval of curvatures that nobody can drive through."""

_ALWAYS: Floats = np.array([-SHARPEST, -4, -2, -1, -0.5, 0, 0.5, 1, 2, 4, SHARPEST])
"""Bounds of intervals where no circle has one, so that on each of them arcs are much alike."""


@dataclass(frozen=True, slots=True)
class Spans:
    """Intervals of curvature, side by side, on each of which the free distance is one number.

    ``low``, ``high`` per metre and ``free`` in metres, `FAR` where nothing is met; shape (m,).
    """

    low: Floats
    high: Floats
    free: Floats

    def at(self, curvature: float) -> float:
        """Metres free along the arc of a curvature."""
        number = int(np.searchsorted(self.high, curvature))
        return float(self.free[min(number, len(self.free) - 1)])


def blocked_curvatures(x: Floats, y: Floats, radius: float) -> tuple[Floats, Floats]:
    """Bounds of the curvatures that circles block; infinite where the robot is inside of one.

    Args:
        x: metres ahead of the robot, shape (n,).
        y: metres to the left, shape (n,).
        radius: metres, inflated by the robot's own.
    """
    power = x * x + y * y - radius * radius
    inside = power <= 1e-9
    # As a rule the robot is inside of none, and there is nothing to choose.
    holds = bool(np.count_nonzero(inside))
    safe = np.where(inside, 1.0, power) if holds else power
    low, high = 2.0 * (y - radius) / safe, 2.0 * (y + radius) / safe
    if holds:
        low[inside], high[inside] = -np.inf, np.inf
    return low, high


def shortest_arcs(x: Floats, y: Floats, radius: float) -> tuple[Floats, Floats]:
    """How far arcs run, at the least, until they enter circles.

    An arc to a point in direction phi at distance rho is rho phi / sin(phi) long, which grows
    with both; one of curvature c turns by 2 phi on the way. The paper takes the shorter of the
    two tangents; what lies on the robot's way is met before those touch, by as much as the
    radius where it is straight ahead.

    Circles that hold the robot already block only ways that lead further in: those ahead.

    Returns:
        Metres that any arc runs to each circle, and radians that it turns, at the least; (n,).
    """
    away = np.sqrt(x * x + y * y)
    outside = away > radius
    aside = np.abs(np.arctan2(y, x)) - np.arcsin(np.minimum(radius / (away + 1e-9), 1.0))
    aside = np.minimum(np.maximum(aside, 1e-6), NEARLY_BEHIND)
    reach, turn = (away - radius) * aside / np.sin(aside), 2.0 * aside
    if np.count_nonzero(outside) < len(outside):
        reach = np.where(outside, reach, np.where(x > 0.5 * radius, 0.0, FAR))
        turn = np.where(outside, turn, 0.0)
    return reach, turn


def free_spans(x: Floats, y: Floats, radius: float, *, within: float = FAR) -> Spans:
    """The free distance as a function of curvature, constant between the bounds of circles.

    Circles that no arc meets ``within`` so many metres are left out, and so are all but the
    `MOST_CIRCLES` that are met first.
    """
    reach, turn = shortest_arcs(x, y, radius)
    near = (reach < within).nonzero()[0]
    if len(near) > MOST_CIRCLES:
        near = near[np.argpartition(reach[near], MOST_CIRCLES)[:MOST_CIRCLES]]
    reach, turn = reach[near], turn[near]
    low, high = blocked_curvatures(x[near], y[near], radius)
    bounds = np.concatenate([low, high, _ALWAYS])
    np.minimum(np.maximum(bounds, -SHARPEST, out=bounds), SHARPEST, out=bounds)
    bounds.sort()
    wide = (bounds[1:] - bounds[:-1] > SLIT).nonzero()[0]
    right, left = bounds.take(wide), bounds.take(wide + 1)
    middle = (0.5 * (left + right))[:, None]
    sharpest = np.maximum(np.abs(left), np.abs(right))[:, None]
    length = np.maximum(reach, turn / sharpest)
    met = np.where((middle > low) & (middle < high), length, FAR)
    return Spans(right, left, np.minimum.reduce(met, axis=1, initial=FAR))
