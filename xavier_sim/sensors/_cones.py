"""A lidar in place of a ring of sonars: the nearest of its beams in each cone."""

from __future__ import annotations

import math

import numpy as np

from xavier_sim.messages import (
    SONAR_CONE,
    SONAR_COUNT,
    SONAR_FARTHEST,
    SONAR_NEAREST,
    SONAR_RING_RADIUS,
)
from xavier_sim.profile import LaserProfile
from xavier_sim.sensors._readings import Ranges


class Cones:
    """Tells what a ring would read that sees as well as a lidar.

    Args:
        profile: of the lidar.
    """

    def __init__(self, profile: LaserProfile) -> None:
        bearings = np.linspace(-profile.view / 2, profile.view / 2, profile.beams)
        facing = np.arange(SONAR_COUNT) * (2.0 * math.pi / SONAR_COUNT)
        off = (bearings - facing[:, None] + math.pi) % (2.0 * math.pi) - math.pi
        self._outside = np.abs(off) > SONAR_CONE / 2

    def read(self, ranges: Ranges) -> Ranges:
        """Readings as of 24 sonars, metres from the ring, from the lidar's ranges."""
        nearest = np.where(self._outside, np.float32(np.inf), ranges).min(axis=1)
        reading = np.maximum(nearest - np.float32(SONAR_RING_RADIUS), np.float32(SONAR_NEAREST))
        return np.where(reading > SONAR_FARTHEST, np.float32(np.inf), reading)
