"""Strangers: what stands or walks in a space that is empty on the map.

The map's spaces are empty rectangles. A sonar that hears something well inside of one, wherever
in its cone that may be, hears somebody, or something that was put there; beams of light that end
well inside of one see them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from navigate.body import (
    BEARINGS,
    CONE_HALF,
    PITCH,
    RING_RADIUS,
    Pose,
    bits_of,
    fresh_sonars,
)
from navigate.driving._surroundings import BEAM_SPREAD
from navigate.driving._view import View
from navigate.maps import Floats, Point
from xavier_sim.messages import Space

INSIDE = 0.25
"""Metres from the walls of the map within which an echo may be theirs."""

SAME = 0.6
"""Metres between two spots that may be of one stranger."""

STEP = 0.2
"""Metres nearer or farther that a stranger must be met at to have moved."""

PARALLAX = 0.3
"""Metres that the robot drives until it sees another side of whatever stands."""

STANDS_AFTER = 1.5
"""Seconds without a step after which it stands."""

FORGOTTEN_AFTER = 1.2
"""Seconds, three rounds of the sonars, for which one is remembered that is heard no more."""

STRANGERS_WITHIN = 3.0
"""Metres within which strangers matter."""

MOST_SONARS, MOST_STRANGERS = 10, 4
"""Sonars of 24 that strangers explain, and strangers who are heard there, that the robot believes
in: where there are more that no wall can be, its pose is wrong."""

FEWEST_BEAMS = 3
"""Beams that must end near each other to be taken for somebody."""


@dataclass
class Stranger:
    """Something that no map knows: where it was met last, and since when it stands there.

    ``at`` is in metres in the map frame, and so are ``stood``, where it was when it was looked at
    from elsewhere last, and ``eye``, where the robot was then. Times are in seconds; ``heard``
    counts readings.
    """

    at: Point
    seen: float
    since: float
    stood: Point
    eye: Point
    heard: int = 1

    def stands(self, now: float) -> bool:
        """Whether it has not moved for some time."""
        return now - self.since > STANDS_AFTER

    @property
    def certain(self) -> bool:
        """Whether it was met more than once: one echo may be a stray."""
        return self.heard > 1


class Strangers:
    """Those around the robot, followed from reading to reading."""

    STATE: ClassVar[tuple[str, ...]] = ("_met",)

    def __init__(self) -> None:
        self.around: list[Stranger] = []

    @property
    def _met(self) -> list[tuple[Any, ...]]:
        return [astuple(one) for one in self.around]

    @_met.setter
    def _met(self, state: list[tuple[Any, ...]]) -> None:
        self.around = [Stranger(*one) for one in state]

    def forget(self) -> None:
        """Know of nobody: the clock was set, or the robot is elsewhere than believed."""
        self.around = []

    def listen(self, view: View, spaces: Sequence[Space]) -> None:
        """Take in the fresh readings of a tick; ``spaces`` are those around the robot."""
        now = view.time
        self.around = [one for one in self.around if 0.0 <= now - one.seen < FORGOTTEN_AFTER]
        for spot in (*strange_echoes(view, spaces), *strange_sights(view, spaces)):
            self._meet(spot, view)

    def _meet(self, spot: Point, view: View) -> None:
        near = min(self.around, key=lambda one: math.dist(one.at, spot), default=None)
        if near is None or math.dist(near.at, spot) > SAME:
            self.around.append(Stranger(spot, view.time, view.time, stood=spot, eye=view.at))
            return
        steps = abs(math.dist(spot, view.at) - math.dist(near.stood, view.at)) > STEP
        if steps:
            near.since = view.time
        if steps or math.dist(near.eye, view.at) > PARALLAX:
            near.stood, near.eye = spot, view.at
        near.at, near.seen, near.heard = spot, view.time, near.heard + 1

    def explained(self, ranges: Floats, pose: Pose, spaces: Sequence[Space]) -> int:
        """Which of 24 sonars hear those who are met for certain, as bits.

        None where that were more than `MOST_SONARS`, or more than `MOST_STRANGERS` of them: walls
        around a robot that is elsewhere than believed look like a crowd.
        """
        certain = [one.at for one in self.around if one.certain]
        if not certain:
            return 0
        near = np.where(np.isfinite(ranges), RING_RADIUS + ranges, 0.0)
        strange = np.zeros(len(ranges), dtype=bool)
        for space in spaces:
            strange |= are_strange(pose, space, near, BEARINGS)
        angles = pose[2] + BEARINGS
        x, y = pose[0] + near * np.cos(angles), pose[1] + near * np.sin(angles)
        own = [strange & (near > 0.0) & (np.hypot(x - at[0], y - at[1]) < SAME) for at in certain]
        theirs = np.logical_or.reduce(own)
        is_crowd = sum(bool(heard.any()) for heard in own) > MOST_STRANGERS
        return 0 if is_crowd or theirs.sum() > MOST_SONARS else bits_of(theirs)


def strange_echoes(view: View, spaces: Sequence[Space]) -> list[Point]:
    """Where fresh readings lie, in the map frame, that no wall can be: well inside a space."""
    ranges, (x, y, theta), spots = view.ranges.tolist(), view.pose, list[Point]()
    for sonar in fresh_sonars(view.fresh):
        away = RING_RADIUS + ranges[sonar]
        if away >= STRANGERS_WITHIN:
            continue
        angle = sonar * PITCH
        if any(is_strange(view.pose, space, away, angle) for space in spaces):
            spots.append((away * math.cos(theta + angle) + x, away * math.sin(theta + angle) + y))
    return spots


def strange_sights(view: View, spaces: Sequence[Space]) -> list[Point]:
    """Where light sees, in the map frame, what no wall can be: the nearest spot of each thing."""
    found: list[Point] = []
    for _, sight in view.sights:
        spots = sight.spots[sight.ranges < STRANGERS_WITHIN]
        if len(spots) < FEWEST_BEAMS:
            continue
        away, bearings = np.hypot(spots[:, 0], spots[:, 1]), np.arctan2(spots[:, 1], spots[:, 0])
        spreads = np.full(len(spots), BEAM_SPREAD)
        strange = np.zeros(len(spots), dtype=bool)
        for space in spaces:
            strange |= are_strange(view.pose, space, away, bearings, spreads)
        if strange.any():
            angles, away = view.pose[2] + bearings[strange], away[strange]
            ends = np.column_stack([np.cos(angles), np.sin(angles)]) * away[:, None]
            found += _apart((ends + view.at)[np.argsort(away, kind="stable")])
    return found


def _apart(spots: Floats) -> list[Point]:
    """Of spots, the nearest first, the first of each bunch of `FEWEST_BEAMS` or more."""
    found: list[Point] = []
    while len(spots) >= FEWEST_BEAMS:
        x, y = spots[0].tolist()
        own = np.hypot(spots[:, 0] - x, spots[:, 1] - y) < SAME
        if own.sum() >= FEWEST_BEAMS:
            found.append((x, y))
        spots = spots[~own]
    return found


def is_strange(pose: Pose, space: Space, away: float, bearing: float) -> bool:
    """Whether an echo is well inside of ``space`` wherever in a sonar's cone it is.

    `are_strange` of one: quicker for the few that are new at a tick.
    """
    low, high = space.low, space.high
    for cone in _CONE:
        angle = pose[2] + bearing + cone
        x, y = pose[0] + away * math.cos(angle), pose[1] + away * math.sin(angle)
        if min(x - low.x, high.x - x, y - low.y, high.y - y) <= INSIDE:
            return False
    return True


def are_strange(
    pose: Pose, space: Space, away: Floats, bearings: Floats, spreads: Floats | None = None
) -> NDArray[np.bool_]:
    """Whether echoes are well inside of ``space`` wherever in a sonar's cone they are.

    Args:
        pose: of the robot, in the map frame.
        space: what is empty on the map.
        away: metres from the robot's centre, shape (n,).
        bearings: radians to the left of ahead, shape (n,).
        spreads: radians to either side within which each may be, shape (n,); else a cone.
    """
    cones = _WHOLE_CONE if spreads is None else _SIDES * spreads
    angles = pose[2] + bearings + cones
    x, y = pose[0] + away * np.cos(angles), pose[1] + away * np.sin(angles)
    across = np.minimum(x - space.low.x, space.high.x - x)
    inset = np.minimum(across, np.minimum(y - space.low.y, space.high.y - y))
    return np.asarray(np.minimum.reduce(inset) > INSIDE)


_SIDES = np.array([-1.0, 0.0, 1.0])[:, None]
_CONE = (-CONE_HALF, 0.0, CONE_HALF)
_WHOLE_CONE = np.array(_CONE)[:, None]
