"""Echoes around the robot: the last of each sonar, what light sees, and near ones a little longer.

Kept in the odometry frame, so that an echo stays where it was heard while the robot moves on. One
that is kept goes early when the sense that found it looks past it: what stood there has walked on.
A sonar's echo may be anywhere across its cone, a beam's is where it is; where light sees what a
sonar hears, the light tells where.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigate.body import (
    BEARINGS,
    CONE_HALF,
    PITCH,
    RING_RADIUS,
    Laser,
    Pose,
    Sight,
    mask_of,
    sonars_of,
)
from navigate.driving._echostore import EchoStore, Indices
from navigate.maps import Floats
from xavier_sim.messages import SONAR_COUNT

NEAR = 0.9
"""Metres below which a sonar's echo is sharp enough to be kept after the sonar has moved on."""

NEAR_LIGHT = 1.2
"""Metres from a laser below which what it sees is kept after it looks elsewhere."""

KEPT_SECONDS = 5.0

BEYOND = 0.3
"""Metres by which a sonar must hear farther than an echo that is not there any more."""

BEYOND_LIGHT = 0.15
"""The same for a beam of light."""

MISSES = 2
"""Readings past an echo that it takes to forget it: one may have glanced off."""

ALIKE = 0.2
"""Metres between the readings of two neighbours that hear the same thing."""

EXPLAINED = 0.12
"""Metres between what a sonar hears and what light sees in its cone that are the same thing."""

ALL_ROUND = 1.8 * math.pi
"""Radians of a laser's view from which it looks everywhere at every tick: nothing is kept."""

BEAM_SPREAD = math.radians(0.5)

_NONE: Floats = np.empty((0, 2))


class Echoes(NamedTuple):
    """What is around the robot: metres ahead and left (n, 2), in its frame.

    ``spreads`` (n,) are the radians to either side within which each may be.
    """

    spots: Floats
    spreads: Floats


class Surroundings:
    """What the sonars have heard and light has seen lately."""

    STATE: ClassVar[tuple[str, ...]] = ("_last", "_heard", "_seen", "_scan", "_time")

    def __init__(self) -> None:
        self._last: Floats = np.full((SONAR_COUNT, 2), np.inf)
        self._heard = EchoStore(seconds=KEPT_SECONDS, misses=MISSES)
        self._seen = EchoStore(seconds=KEPT_SECONDS, misses=MISSES)
        self._scan: Floats = _NONE
        self._time = 0.0

    def see(self, odom: Pose, sights: Sequence[tuple[Laser, Sight]], time: float) -> None:
        """Take in what lasers see at a tick."""
        self._time, scans = time, [_NONE]
        for laser, sight in sights:
            spots = _to_odom(odom, sight.spots)
            if laser.view < ALL_ROUND:
                near = sight.ranges < NEAR_LIGHT
                self._forget_seen(odom, laser, sight)
                self._seen.enter(spots[near], time)
                spots[near] = np.inf
            scans.append(spots)
        self._scan = scans[-1] if len(scans) < 3 else np.concatenate(scans)

    def hear(
        self,
        odom: Pose,
        ranges: Floats,
        fresh: int,
        time: float,
        *,
        lit: Floats | None = None,
    ) -> None:
        """Take in the fresh ones of 24 ``ranges`` (metres from the ring).

        Those that hear what is seen in their cones anyway, ``lit`` metres away, tell nothing new.
        """
        self._time = time
        sonars = sonars_of(fresh)
        readings = ranges[sonars]
        self._forget_heard(odom, ranges, fresh)
        spots = _spots(odom, BEARINGS[sonars] + lean(ranges, sonars), readings)
        near = readings < NEAR
        if lit is not None:
            heard = np.isfinite(readings)
            explained = np.abs(lit[sonars] - np.where(heard, readings, 0.0)) < EXPLAINED
            explained &= heard
            near &= ~explained
            spots[explained] = np.inf
        self._last[sonars] = spots
        self._heard.enter(spots[near], time)

    def touch(self, odom: Pose, direction: float, time: float) -> None:
        """Remember a contact as if it had been heard: the sonars may not see it."""
        self._heard.enter(_spots(odom, np.array([direction]), np.array([0.1])), time)

    def picture(self, odom: Pose, *, within: float) -> Echoes:
        """All that is within some metres of the robot now."""
        heard = self._heard.spots(self._heard.live(self._time))
        seen = self._seen.spots(self._seen.live(self._time))
        spots = np.concatenate([self._last, heard, self._scan, seen]) - odom[:2]
        near = np.einsum("ij,ij->i", spots, spots) < within**2
        spreads = np.full(len(spots), CONE_HALF)
        spreads[SONAR_COUNT + len(heard) :] = BEAM_SPREAD
        cos, sin = math.cos(odom[2]), math.sin(odom[2])
        turned = spots[near] @ np.array([[cos, -sin], [sin, cos]])
        return Echoes(np.asarray(turned), spreads[near])

    def _forget_heard(self, odom: Pose, ranges: Floats, fresh: int) -> None:
        """Miss the kept echoes that fresh readings of their direction went past."""
        cells = self._heard.live(self._time)
        if len(cells) == 0 or not fresh:
            return
        away = self._heard.spots(cells) - odom[:2]
        look = np.arctan2(away[:, 1], away[:, 0]) - odom[2]
        sonar = np.rint(look * (1.0 / PITCH)).astype(np.intp) % SONAR_COUNT
        past = np.hypot(away[:, 0], away[:, 1]) < RING_RADIUS + ranges[sonar] - BEYOND
        self._heard.miss(cells[past & mask_of(fresh)[sonar]])

    def _forget_seen(self, odom: Pose, laser: Laser, sight: Sight) -> None:
        """Miss what is kept of light where beams of now go past."""
        cells = self._seen.live(self._time)
        if len(cells) == 0:
            return
        spots = _to_robot(odom, self._seen.spots(cells))
        spots[:, 0] -= laser.ahead
        look = np.arctan2(spots[:, 1], spots[:, 0])
        beam = np.rint((look / laser.view + 0.5) * (laser.beams - 1)).astype(np.intp)
        inside = (beam >= 0) & (beam < laser.beams)
        range_there = sight.ranges[np.where(inside, beam, 0)]
        past = np.hypot(spots[:, 0], spots[:, 1]) < range_there - BEYOND_LIGHT
        self._seen.miss(cells[past & inside & np.isfinite(range_there)])


def lean(ranges: Floats, sonars: Indices) -> Floats:
    """Radians to the left of its axis at which a sonar's echo likely is, shape of ``sonars``.

    What is heard by one of its neighbours as well is between the two.
    """
    own = np.where(np.isfinite(ranges[sonars]), ranges[sonars], -np.inf)
    left = np.abs(ranges[(sonars + 1) % SONAR_COUNT] - own) < ALIKE
    right = np.abs(ranges[sonars - 1] - own) < ALIKE
    return np.asarray(0.5 * PITCH * (left.astype(np.float64) - right))


def _spots(odom: Pose, bearings: Floats, ranges: Floats) -> Floats:
    """Where readings lie, shape (n, 2); infinite where nothing was heard."""
    heard: NDArray[np.bool_] = np.isfinite(ranges)
    distance, angle = RING_RADIUS + np.where(heard, ranges, 0.0), odom[2] + bearings
    spots = np.empty((len(ranges), 2))
    spots[:, 0] = odom[0] + distance * np.cos(angle)
    spots[:, 1] = odom[1] + distance * np.sin(angle)
    spots[~heard] = np.inf
    return spots


def _to_odom(odom: Pose, spots: Floats) -> Floats:
    """Spots (n, 2) ahead of the robot and to its left, in dead reckoning."""
    cos, sin = math.cos(odom[2]), math.sin(odom[2])
    return np.asarray(spots @ np.array([[cos, sin], [-sin, cos]]) + odom[:2])


def _to_robot(odom: Pose, spots: Floats) -> Floats:
    """Spots (n, 2) of dead reckoning, ahead of the robot and to its left."""
    cos, sin = math.cos(odom[2]), math.sin(odom[2])
    return np.asarray((spots - odom[:2]) @ np.array([[cos, -sin], [sin, cos]]))
