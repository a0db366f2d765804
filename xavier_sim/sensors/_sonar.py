"""The ring of 24 sonars: wide cones, noise, echoes that glance off, and echoes from nowhere."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from xavier_sim.messages import SONAR_COUNT
from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import SonarProfile
from xavier_sim.sensors._caster import Caster, Floats
from xavier_sim.sensors._crosstalk import Crosstalk
from xavier_sim.sensors._readings import Pose, Ranges, plain, ranges_of

PITCH = 2.0 * math.pi / SONAR_COUNT


class Part:
    """Sonars that fire together: their numbers, bits and bearings, and the sonar of each ray."""

    def __init__(self, sonars: NDArray[np.intp], rays: int) -> None:
        self.sonars = sonars
        self.bits: int = sum(1 << sonar for sonar in sonars.tolist())
        self.bearings = sonars * PITCH
        self.owners = np.repeat(np.arange(len(sonars)), rays)


class SonarRing:
    """Fires a part of the ring at each tick and remembers the last reading of each sonar.

    Args:
        profile: of the sonars.
        seed: of their noise.
    """

    def __init__(self, profile: SonarProfile, seed: int) -> None:
        self._profile = profile
        self._random = stream(seed, "sonar")
        half = profile.cone / 2
        self._spread = np.linspace(-half, half, profile.rays)
        self.readings: Ranges = np.full(SONAR_COUNT, np.inf, dtype=np.float32)
        self.stuck: dict[int, float] = {}
        """What the faulty sonars read whatever there is, metres; ``inf`` for a dead one."""
        ring = np.arange(SONAR_COUNT)
        self._whole = Part(ring, profile.rays)
        self._parts = [Part(ring[p :: profile.phases], profile.rays) for p in range(profile.phases)]
        self._slope = 1.0 / (profile.specular_to - profile.specular_from)
        self._crosstalk = Crosstalk(profile.crosstalk, seed) if profile.crosstalk else None

    def fire(self, tick: int, caster: Caster, pose: Pose, *, circles: Floats | None = None) -> int:
        """Fire the part of the ring whose turn it is, and return its bits.

        Args:
            tick: of the world.
            caster: of the walls.
            pose: of the robot.
            circles: shape (m, 3), x, y and radius in metres of whoever stands about.
        """
        part = self._parts[tick % self._profile.phases]
        return self._measure(part, pose, caster, circles)

    def fire_all(self, caster: Caster, pose: Pose, *, circles: Floats | None = None) -> int:
        """Fire the whole ring at once, as when it is switched on."""
        return self._measure(self._whole, pose, caster, circles)

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs, as plain numbers; None stands for no echo."""
        return {
            "readings": plain(self.readings),
            "random": stream_state(self._random),
            "stuck": dict(zip(map(str, self.stuck), plain(self.stuck.values()), strict=True)),
            "crosstalk": self._crosstalk.snapshot() if self._crosstalk else None,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.readings = ranges_of(state["readings"])
        restore_stream(self._random, state["random"])
        kept = state.get("stuck", {})
        self.stuck = dict(zip(map(int, kept), ranges_of(kept.values()).tolist(), strict=True))
        if self._crosstalk and state.get("crosstalk"):
            self._crosstalk.restore(state["crosstalk"])

    def _measure(self, part: Part, pose: Pose, caster: Caster, circles: Floats | None) -> int:
        """Take new readings of a part, metres from the ring, and return its bits."""
        profile, (x, y, theta) = self._profile, pose
        facing = theta + part.bearings
        mounts = np.empty((len(facing), 2))
        mounts[:, 0] = x + profile.ring_radius * np.cos(facing)
        mounts[:, 1] = y + profile.ring_radius * np.sin(facing)
        angles = (facing[:, None] + self._spread).ravel()
        distance, cosine = caster.cast(mounts[part.owners], angles, circles=circles)
        distance[self._lost(cosine)] = np.inf
        cones = distance.reshape(len(facing), profile.rays)
        echo = cones.min(axis=1)
        if self._crosstalk:
            bearing = facing + self._spread[cones.argmin(axis=1)]
            echo = self._crosstalk.disturb(mounts, bearing, echo)
        self.readings[part.sonars] = self._disturb(echo)
        for number, reading in self.stuck.items():
            if part.bits >> number & 1:
                self.readings[number] = reading
        return part.bits

    def _lost(self, cosine: Floats) -> NDArray[np.bool_]:
        """Which rays' echoes glance off, by the cosines of their incidence."""
        profile = self._profile
        incidence = np.arccos(np.minimum(cosine, 1.0))
        share = (incidence - profile.specular_from) * self._slope
        loss = np.minimum(np.maximum(share, 0.0), 1.0) * profile.specular_loss
        if profile.specular_whole:
            draw = np.repeat(self._random.random(len(cosine) // profile.rays), profile.rays)
        else:
            draw = self._random.random(len(cosine))
        lost: NDArray[np.bool_] = draw < loss
        return lost

    def _disturb(self, echo: Floats) -> Floats:
        """Add noise and outliers; what is nearer than the nearest reads as the nearest."""
        profile, count = self._profile, len(echo)
        odds, place = self._random.random((2, count))
        known = np.where(np.isinf(echo), 0.0, echo)
        sigma = profile.noise + profile.noise_share * known
        reading = echo + sigma * self._random.standard_normal(count)
        astray = odds < profile.outliers
        if astray.any():
            stray = profile.nearest + place * (profile.farthest - profile.nearest)
            reading[astray] = stray[astray]
        reading[reading > profile.farthest] = np.inf
        return np.maximum(reading, profile.nearest)
