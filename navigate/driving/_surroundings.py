"""Echoes around the robot: the last of each sonar, what light sees, and near ones a little longer.

Kept in the odometry frame, so that an echo stays where it was heard while the robot moves on. One
that is kept goes early when the sense that found it looks past it: what stood there has walked on.
A sonar's echo may be anywhere across its cone, a beam's is where it is; where light sees what a
sonar hears, the light tells where.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import compress
from typing import ClassVar, NamedTuple

import numpy as np

from navigate.body import (
    CONE_HALF,
    PITCH,
    RING_RADIUS,
    Laser,
    Pose,
    Sight,
    fresh_sonars,
    mask_of,
    sonars_of,
)
from navigate.driving._echostore import EchoStore
from navigate.maps import Floats, Point
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
_NOWHERE: Point = (math.inf, math.inf)


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
        if not fresh:
            return
        self._forget_heard(odom, ranges, fresh)
        readings, sonars = ranges.tolist(), fresh_sonars(fresh)
        spots = [
            _spot(odom, sonar * PITCH + lean(readings, sonar), readings[sonar]) for sonar in sonars
        ]
        near = [readings[sonar] < NEAR for sonar in sonars]
        if lit is not None:
            seen = lit.tolist()
            for number, sonar in enumerate(sonars):
                if abs(seen[sonar] - readings[sonar]) < EXPLAINED:
                    spots[number], near[number] = _NOWHERE, False
        self._last[sonars_of(fresh)] = spots
        if any(near):
            self._heard.enter(np.array(list(compress(spots, near))), time)

    def touch(self, odom: Pose, direction: float, time: float) -> None:
        """Remember a contact as if it had been heard: the sonars may not see it."""
        self._heard.enter(np.array([_spot(odom, direction, 0.1)]), time)

    def picture(self, odom: Pose, *, within: float) -> Echoes:
        """All that is within some metres of the robot now."""
        heard = self._heard.spots(self._heard.live(self._time))
        seen = self._seen.spots(self._seen.live(self._time))
        spots = np.concatenate([self._last, heard, self._scan, seen])
        spots -= odom[:2]
        squares = spots * spots
        near = (squares[:, 0] + squares[:, 1] < within**2).nonzero()[0]
        spreads = np.where(near < SONAR_COUNT + len(heard), CONE_HALF, BEAM_SPREAD)
        return Echoes(_turned(spots.take(near, axis=0), odom[2]), spreads)

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
        spots = _turned(self._seen.spots(cells) - odom[:2], odom[2])
        spots[:, 0] -= laser.ahead
        look = np.arctan2(spots[:, 1], spots[:, 0])
        beam = np.rint((look / laser.view + 0.5) * (laser.beams - 1)).astype(np.intp)
        inside = (beam >= 0) & (beam < laser.beams)
        range_there = sight.ranges[np.where(inside, beam, 0)]
        past = np.hypot(spots[:, 0], spots[:, 1]) < range_there - BEYOND_LIGHT
        self._seen.miss(cells[past & inside & np.isfinite(range_there)])


def lean(ranges: Sequence[float], sonar: int) -> float:
    """Radians to the left of its axis at which the echo of a sonar likely is.

    What is heard by one of its neighbours as well is between the two.
    """
    own = ranges[sonar]
    left = abs(ranges[(sonar + 1) % SONAR_COUNT] - own) < ALIKE
    right = abs(ranges[sonar - 1] - own) < ALIKE
    return 0.5 * PITCH * (left - right)


def _spot(odom: Pose, bearing: float, reading: float) -> Point:
    """Where a reading lies; infinitely far off where nothing was heard.

    The readings of a tick are few: numbers are quicker one by one than numpy's calls for all.
    """
    if not math.isfinite(reading):
        return _NOWHERE
    distance, angle = RING_RADIUS + reading, odom[2] + bearing
    return odom[0] + distance * math.cos(angle), odom[1] + distance * math.sin(angle)


def _to_odom(odom: Pose, spots: Floats) -> Floats:
    """Spots (n, 2) ahead of the robot and to its left, in dead reckoning."""
    placed = _turned(spots, -odom[2])
    placed += odom[:2]
    return placed


def _turned(spots: Floats, angle: float) -> Floats:
    """Spots (n, 2) as they are from axes that are turned to the left by ``angle``."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(spots @ np.array([[cos, -sin], [sin, cos]]))
