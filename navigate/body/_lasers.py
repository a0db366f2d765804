"""What light tells of range: points along thin beams, and what sonars would read for them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navigate.body._sonarring import BEARINGS, CONE_HALF, RING_RADIUS
from navigate.maps import Floats
from xavier_sim.messages import (
    LIDAR_BEAMS,
    LIDAR_FARTHEST,
    LIDAR_VIEW,
    STRIPER_AHEAD,
    STRIPER_BEAMS,
    STRIPER_FARTHEST,
    STRIPER_NEAREST,
    STRIPER_VIEW,
)

AWAY = 1e6
"""Metres off at which a beam that sees nothing is said to end: finite, to be reckoned with."""

LIDAR_NEAREST = 0.05
"""Metres below which a lidar sees nothing."""


_NOTHING: Floats = np.full(len(BEARINGS), np.inf)
_MOUNTS: Floats = RING_RADIUS * np.column_stack([np.cos(BEARINGS), np.sin(BEARINGS)])


@dataclass(frozen=True, slots=True)
class Sight:
    """What a laser sees at a tick.

    ``ranges`` (beams,) are metres from the laser, inf where nothing was seen; ``spots`` (beams, 2)
    the same as metres ahead of the robot and to its left, `AWAY` off for nothing. ``ring`` (24,)
    is what sonars would read that heard just that: the nearest spot in each cone, metres from the
    ring, inf for none.
    """

    ranges: Floats
    spots: Floats
    ring: Floats


class Laser:
    """Where the beams of a laser go.

    Args:
        beams: how many there are, spread evenly from the right to the left.
        view: radians from the first to the last, straight ahead in the middle.
        ahead: metres from the robot's centre to the laser.
        nearest: metres below which nothing is seen.
        farthest: metres beyond which nothing is seen.
    """

    def __init__(
        self, *, beams: int, view: float, ahead: float, nearest: float, farthest: float
    ) -> None:
        self.beams, self.view, self.ahead = beams, view, ahead
        self.nearest, self.farthest = nearest, farthest
        self.bearings: Floats = np.linspace(-view / 2, view / 2, beams)
        self._unit = np.column_stack([np.cos(self.bearings), np.sin(self.bearings)])
        off = (self.bearings - BEARINGS[:, None] + math.pi) % (2.0 * math.pi) - math.pi
        inside = np.abs(off) < CONE_HALF
        most = int(inside.sum(axis=1).max())
        # Cones with fewer beams than others repeat one that is none, behind the last.
        padded = [np.flatnonzero(row) for row in inside]
        cones = [np.concatenate([row, np.full(most - len(row), beams)]) for row in padded]
        self._lit = np.flatnonzero(inside.any(axis=1))
        self._cones = np.array(cones, np.intp)[self._lit]
        self._mounts = _MOUNTS[self._lit, None]
        self.spacing = step = view / (beams - 1)
        width = inside.sum(axis=1) * step
        self.whole: NDArray[np.bool_] = np.asarray(width > 2.0 * CONE_HALF - 2.0 * step)
        """Whether beams fill the cone of each sonar, shape (24,)."""

    def look(self, beams: NDArray[np.float32]) -> Sight | None:
        """What is seen along ``beams``, in metres; None from a laser that is not there."""
        if len(beams) != self.beams:
            return None
        readings = beams.astype(np.float64)
        sound = (readings >= self.nearest) & (readings <= self.farthest)
        spots = np.empty((self.beams + 1, 2))
        np.multiply(self._unit, np.where(sound, readings, AWAY)[:, None], out=spots[:-1])
        spots[:-1, 0] += self.ahead
        spots[-1] = AWAY
        off = spots.take(self._cones, axis=0)
        off -= self._mounts
        off *= off
        nearest = np.sqrt(np.minimum.reduce(off[..., 0] + off[..., 1], axis=1))
        ring = _NOTHING.copy()
        ring[self._lit] = np.where(nearest < 0.5 * AWAY, nearest, np.inf)
        return Sight(np.where(sound, readings, np.inf), spots[:-1], ring)


STRIPER = Laser(
    beams=STRIPER_BEAMS,
    view=STRIPER_VIEW,
    ahead=STRIPER_AHEAD,
    nearest=STRIPER_NEAREST,
    farthest=STRIPER_FARTHEST,
)
"""The light striper: the camera sees where a stripe of light falls."""

LIDAR = Laser(
    beams=LIDAR_BEAMS,
    view=LIDAR_VIEW,
    ahead=0.0,
    nearest=LIDAR_NEAREST,
    farthest=LIDAR_FARTHEST,
)
"""A lidar that turns all round."""
