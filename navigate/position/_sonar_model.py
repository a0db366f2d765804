"""How probable sonar readings are at a pose of the map.

Cones are wide, a door may be open or shut, echoes glance off or come from nowhere. After Thrun,
Burgard & Fox, Probabilistic Robotics, chapter 6.3.
"""

from __future__ import annotations

import numpy as np

from navigate.body import BEARINGS, RING_RADIUS, Pose
from navigate.maps import Floats, Floor
from navigate.position._expected import REACH, ExpectedRanges

RANGE_SIGMA = 0.11
"""Doubt about an expected range, metres: the map's errors, the table's cells, the noise."""

OPEN_SHARE, SHUT_SHARE, STRAY_SHARE = 0.58, 0.22, 0.20
AGREES = 0.35
"""Metres within which a reading speaks for a pose."""


class SonarModel:
    """The readings to expect on one floor; the table behind it fills as it is used."""

    def __init__(self, floor: Floor) -> None:
        self._expected = ExpectedRanges(floor)

    def log_likelihood(
        self, x: Floats, y: Floats, theta: Floats, ranges: Floats, bearings: Floats
    ) -> Floats:
        """Log likelihoods of readings, summed for each of n poses: shape (n,)."""
        aside, ahead = (
            RING_RADIUS * np.sin(bearings[:, None]),
            RING_RADIUS * np.cos(bearings[:, None]),
        )
        cos, sin = np.cos(theta), np.sin(theta)
        opened, shut = self._expected.at(
            x + cos * ahead - sin * aside, y + sin * ahead + cos * aside, theta + bearings[:, None]
        )
        seen = np.minimum(ranges, REACH)[:, None]
        scale = -0.5 / (RANGE_SIGMA + 0.02 * seen) ** 2
        fit = OPEN_SHARE * np.exp(scale * (seen - opened) ** 2)
        fit += SHUT_SHARE * np.exp(scale * (seen - shut) ** 2)
        return np.asarray(np.log(np.multiply.reduce(fit + STRAY_SHARE * 0.2, axis=0)))

    def agreeing(self, pose: Pose, ranges: Floats, bearings: Floats) -> Floats:
        """1.0 for each reading that speaks for ``pose``, 0.0 for the others."""
        look = pose[2] + bearings
        x, y = pose[0] + RING_RADIUS * np.cos(look), pose[1] + RING_RADIUS * np.sin(look)
        seen = np.minimum(ranges, REACH)
        fits = [np.abs(seen - guess) < AGREES for guess in self._expected.at(x, y, look)]
        return np.asarray(fits[0] | fits[1], dtype=np.float64)

    def fit(self, pose: Pose, ranges: Floats) -> float:
        """The share of a ring of readings that a robot at ``pose`` would have, 0 to 1."""
        heard = np.flatnonzero(np.isfinite(ranges))
        if len(heard) == 0:
            return 0.0
        return float(self.agreeing(pose, ranges[heard], BEARINGS[heard]).mean())
