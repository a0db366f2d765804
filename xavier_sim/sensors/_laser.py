"""Range by light: the striper, which triangulates, and the lidar, which times the flight."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import LaserProfile
from xavier_sim.sensors._caster import Bundle, Floats
from xavier_sim.sensors._readings import Pose, Ranges, plain, ranges_of


class Laser:
    """Sweeps its view at each tick and remembers what it saw.

    `aim` says which rays that takes, `see` is told what they met.

    ``ranges`` has shape (beams,), from the right to the left, metres from the laser; ``inf``
    where nothing came back or it was too near.

    Args:
        profile: of the laser.
        seed: of its noise.
        name: of its stream of noise.
    """

    def __init__(self, profile: LaserProfile, seed: int, name: str) -> None:
        self._profile = profile
        self._random = stream(seed, name)
        self._bearings = np.linspace(-profile.view / 2, profile.view / 2, profile.beams)
        self._growth = profile.dropout_growth / profile.farthest**2
        self._least_cosine = math.cos(profile.most_askance)
        self.metres_off, self.turned = 0.0, 0.0
        """By how much a knocked laser measures too far, metres, and looks to the left, radians."""
        self.ranges: Ranges = np.full(profile.beams, np.inf, dtype=np.float32)

    def aim(self, pose: Pose) -> Bundle:
        """The rays of a sweep, from where the robot stands."""
        profile, (x, y, theta) = self._profile, pose
        starts = np.empty((profile.beams, 2))
        starts[:, 0] = x + profile.ahead * math.cos(theta)
        starts[:, 1] = y + profile.ahead * math.sin(theta)
        return Bundle(starts, theta + self.turned + self._bearings)

    def see(self, distance: Floats, cosine: Floats) -> None:
        """Take new ranges of what a sweep met."""
        self.ranges = self._disturb(distance, cosine).astype(np.float32)

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs, as plain numbers."""
        return {
            "ranges": plain(self.ranges),
            "offset": [self.metres_off, self.turned],
            "random": stream_state(self._random),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.ranges = ranges_of(state["ranges"])
        self.metres_off, self.turned = state.get("offset", (0.0, 0.0))
        restore_stream(self._random, state["random"])

    def _disturb(self, true: Floats, cosine: Floats) -> Floats:
        """Add noise and lose beams."""
        profile, count = self._profile, len(true)
        draw, seen = self._random.random(count), self._random.standard_normal(count)
        square = np.square(np.minimum(true, profile.farthest))
        seen *= profile.noise_square * square + profile.noise
        seen += true + self.metres_off
        square *= self._growth
        square += profile.dropouts
        lost = draw < square
        lost |= cosine < self._least_cosine
        lost |= seen < profile.nearest
        lost |= seen > profile.farthest
        np.copyto(seen, np.inf, where=lost)
        return seen
