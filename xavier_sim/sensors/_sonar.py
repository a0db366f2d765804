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

PITCH = 2.0 * math.pi / SONAR_COUNT


class SonarRing:
    """Fires a part of the ring at each tick and remembers the last reading of each sonar."""

    def __init__(self, profile: SonarProfile, seed: int) -> None:
        self._profile = profile
        self._random = stream(seed, "sonar")
        half = profile.cone / 2
        self._spread = np.linspace(-half, half, profile.rays)
        self.readings: NDArray[np.float32] = np.full(SONAR_COUNT, np.inf, dtype=np.float32)
        self._phases = [np.arange(p, SONAR_COUNT, profile.phases) for p in range(profile.phases)]
        self._slope = 1.0 / (profile.specular_to - profile.specular_from)

    def fire(
        self,
        tick: int,
        caster: Caster,
        x: float,
        y: float,
        theta: float,
        *,
        circles: Floats | None = None,
    ) -> int:
        """Fire the part of the ring whose turn it is, and return its bits.

        Args:
            tick: of the world.
            caster: of the walls.
            x: of the robot, metres.
            y: likewise.
            theta: its heading, radians.
            circles: shape (m, 3), x, y and radius in metres of whoever stands about.
        """
        part = self._phases[tick % self._profile.phases]
        return self._measure(part, (x, y, theta), caster, circles)

    def fire_all(
        self, caster: Caster, x: float, y: float, theta: float, *, circles: Floats | None = None
    ) -> int:
        """Fire the whole ring at once, as when it is switched on."""
        return self._measure(np.arange(SONAR_COUNT), (x, y, theta), caster, circles)

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs, as plain numbers; None stands for no echo."""
        readings = [float(r) if math.isfinite(r) else None for r in self.readings]
        return {"readings": readings, "random": stream_state(self._random)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        readings = [math.inf if r is None else r for r in state["readings"]]
        self.readings = np.array(readings, dtype=np.float32)
        restore_stream(self._random, state["random"])

    def _measure(
        self,
        part: NDArray[np.intp],
        pose: tuple[float, float, float],
        caster: Caster,
        circles: Floats | None,
    ) -> int:
        """Take new readings of the sonars ``part``, metres from the ring, and return their bits."""
        profile, (x, y, theta) = self._profile, pose
        facing = theta + part * PITCH
        mounts = np.empty((len(part), 2))
        mounts[:, 0] = x + profile.ring_radius * np.cos(facing)
        mounts[:, 1] = y + profile.ring_radius * np.sin(facing)
        angles = (facing[:, None] + self._spread).ravel()
        starts = np.repeat(mounts, profile.rays, axis=0)
        distance, cosine = caster.cast(starts, angles, circles=circles)
        lost = self._random.random(len(angles)) < self._loss(cosine)
        distance[lost] = np.inf
        echo = distance.reshape(len(part), profile.rays).min(axis=1)
        self.readings[part] = self._disturb(echo)
        return sum(1 << i for i in part.tolist())

    def _loss(self, cosine: Floats) -> Floats:
        """The chance that an echo glances off, by the cosine of its incidence."""
        profile = self._profile
        incidence = np.arccos(np.minimum(cosine, 1.0))
        share = (incidence - profile.specular_from) * self._slope
        return np.clip(share, 0.0, 1.0) * profile.specular_loss

    def _disturb(self, echo: Floats) -> Floats:
        """Add noise and outliers; what is nearer than the nearest reads as the nearest."""
        profile, count = self._profile, len(echo)
        draw = self._random.random((2, count))
        sigma = profile.noise + profile.noise_share * np.where(np.isinf(echo), 0.0, echo)
        noisy = echo + sigma * self._random.standard_normal(count)
        stray = profile.nearest + draw[1] * (profile.farthest - profile.nearest)
        reading = np.where(draw[0] < profile.outliers, stray, noisy)
        reading = np.where(reading > profile.farthest, np.inf, reading)
        return np.maximum(reading, profile.nearest)
