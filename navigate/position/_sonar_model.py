"""How probable sonar readings are at a pose of the map.

Cones are wide, a door may be open or shut, echoes glance off or come from nowhere. After Thrun,
Burgard & Fox, Probabilistic Robotics, chapter 6.3, with likelihoods from a table.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from navigate.body import BEARINGS, RING_RADIUS, Pose
from navigate.maps import Floats, Floor
from navigate.position._expected import (
    CODE,
    DIRECTIONS,
    OPEN_MASK,
    REACH,
    SHUT_BITS,
    Codes,
    ExpectedRanges,
    Indices,
    direction_of,
    ranges_of,
)

RANGE_SIGMA = 0.11
"""Doubt about an expected range, metres: the map's errors, the table's cells, the noise."""

OPEN_SHARE, SHUT_SHARE, STRAY_SHARE = 0.58, 0.22, 0.20
AGREES = 0.35
"""Metres within which a reading speaks for a pose."""


def _likelihoods(share: float, least: float) -> NDArray[np.float32]:
    """Likelihood of each reading where each range is expected, as codes: shape (256 * 256,)."""
    metres = np.arange(256) * CODE
    doubt = RANGE_SIGMA + 0.02 * metres
    misses = (metres[:, None] - metres) / doubt[:, None]
    return np.asarray(share * np.exp(-0.5 * misses**2) + least, dtype=np.float32).ravel()


_OPEN = _likelihoods(OPEN_SHARE, STRAY_SHARE * 0.2)
_SHUT = _likelihoods(SHUT_SHARE, 0.0)
_AHEAD: Floats = RING_RADIUS * np.cos(BEARINGS)[:, None]
_LEFT: Floats = RING_RADIUS * np.sin(BEARINGS)[:, None]
_LOOK: Indices = direction_of(BEARINGS)[:, None]
_WRAPPED: Indices = np.arange(2 * DIRECTIONS) % DIRECTIONS


class SonarModel:
    """The readings to expect on one floor; the table behind it fills as it is used."""

    def __init__(self, floor: Floor) -> None:
        self.expected = ExpectedRanges(floor)

    def expect(self, x: Floats, y: Floats, theta: Floats, sonars: Indices) -> Codes:
        """What k sonars, by number, of n poses should read: codes (k, n)."""
        cos, sin = np.cos(theta), np.sin(theta)
        ahead, left = _AHEAD[sonars], _LEFT[sonars]
        look = _WRAPPED.take(direction_of(theta) + _LOOK[sonars])
        mount_x, mount_y = cos * ahead, sin * ahead
        mount_x -= sin * left
        mount_x += x
        mount_y += cos * left
        mount_y += y
        return self.expected.codes(mount_x, mount_y, look)

    def log_likelihood(
        self, x: Floats, y: Floats, theta: Floats, ranges: Floats, sonars: Indices
    ) -> Floats:
        """Log likelihoods of readings (k,) of some sonars, summed for each of n poses: (n,)."""
        return log_likelihood(ranges, self.expect(x, y, theta, sonars))

    def fit(self, pose: Pose, ranges: Floats) -> float:
        """The share of a ring of readings that a robot at ``pose`` would have, 0 to 1."""
        heard = np.flatnonzero(np.isfinite(ranges))
        if len(heard) == 0:
            return 0.0
        x, y, theta = np.array(pose)[:, None]
        return float(agreeing(ranges[heard], self.expect(x, y, theta, heard)[:, 0]).mean())


def log_likelihood(ranges: Floats, expected: Codes) -> Floats:
    """Log likelihoods (n,) of readings (k,) where codes (k, n) are expected."""
    seen = np.rint(np.minimum(ranges, REACH) * (1.0 / CODE)).astype(np.intp) << 8
    fit = _OPEN.take((expected & OPEN_MASK) + seen[:, None])
    fit += _SHUT.take((expected >> SHUT_BITS) + seen[:, None])
    return np.asarray(np.log(np.multiply.reduce(fit, axis=0)), dtype=np.float64)


def agreeing(ranges: Floats, expected: Codes) -> Floats:
    """1.0 for each of the readings (k,) that agrees with a code (k,) that is expected, else 0.0."""
    seen = np.minimum(ranges, REACH)
    fits = [np.abs(seen - metres) < AGREES for metres in ranges_of(expected)]
    return np.asarray(fits[0] | fits[1], dtype=np.float64)
