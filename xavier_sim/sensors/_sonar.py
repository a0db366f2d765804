"""The ring of 24 sonars: wide cones, noise, echoes that glance off, and echoes from nowhere."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from xavier_sim.messages import SONAR_COUNT
from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import SonarProfile
from xavier_sim.sensors._caster import Bundle, Floats
from xavier_sim.sensors._crosstalk import Crosstalk
from xavier_sim.sensors._readings import Pose, Ranges, plain, ranges_of

PITCH = 2.0 * math.pi / SONAR_COUNT


class Part:
    """Sonars that fire together: their numbers, bits and bearings, and the sonar of each ray."""

    def __init__(self, sonars: NDArray[np.intp], rays: int) -> None:
        self.sonars = sonars
        self.bits: int = sum(1 << sonar for sonar in sonars.tolist())
        self.bearings: Floats = sonars.astype(np.float64) * PITCH
        self.owners = np.repeat(np.arange(len(sonars)), rays)


class Volley(NamedTuple):
    """The rays of sonars that fire together.

    ``facing`` are the sonars' bearings in radians and ``mounts`` where they sit, metres, shape
    (k, 2); ``rays`` start and look from there, those of each sonar together.
    """

    part: Part
    facing: Floats
    mounts: Floats
    rays: Bundle


class SonarRing:
    """Fires a part of the ring at each tick and remembers the last reading of each sonar.

    `aim` says which rays that takes, `hear` is told what they met.

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

    def aim(self, tick: int | None, pose: Pose) -> Volley:
        """The rays of the part of the ring whose turn it is at a tick, of all of it for None."""
        part = self._whole if tick is None else self._parts[tick % self._profile.phases]
        radius, (x, y, theta) = self._profile.ring_radius, pose
        facing = theta + part.bearings
        mounts = np.empty((len(facing), 2))
        mounts[:, 0] = radius * np.cos(facing) + x
        mounts[:, 1] = radius * np.sin(facing) + y
        looks = (facing[:, None] + self._spread).ravel()
        return Volley(part, facing, mounts, Bundle(mounts.take(part.owners, axis=0), looks))

    def hear(self, volley: Volley, distance: Floats, cosine: Floats) -> int:
        """Take new readings of what a volley met, and return the bits of its sonars.

        A tick's sonars are few: numbers are quicker one by one than numpy's calls for all.
        """
        part, nearest = volley.part, self._nearest(distance.tolist(), self._loss(cosine))
        echoes = [echo for echo, _ in nearest]
        if self._crosstalk and (draw := self._crosstalk.draw(len(echoes))) is not None:
            bearing = volley.facing + self._spread[[ray for _, ray in nearest]]
            echoes = self._crosstalk.disturb(draw, volley.mounts, bearing, echoes)
        self.readings[part.sonars] = self._disturb(echoes)
        for number, reading in self.stuck.items():
            if part.bits >> number & 1:
                self.readings[number] = reading
        return part.bits

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

    def _nearest(self, distance: list[float], loss: list[float]) -> list[tuple[float, int]]:
        """Metres to the nearest of each cone that is not lost, and the number of its ray there."""
        profile, count = self._profile, self._profile.rays
        whole = profile.specular_whole
        draws = self._random.random(len(distance) // count if whole else len(distance)).tolist()
        found = []
        for cone in range(len(distance) // count):
            echo, nearest = math.inf, 0
            for ray in range(count):
                at = cone * count + ray
                if distance[at] < echo and draws[cone if whole else at] >= loss[at]:
                    echo, nearest = distance[at], ray
            found.append((echo, nearest))
        return found

    def _loss(self, cosine: Floats) -> list[float]:
        """How likely each ray's echo glances off, by the cosine of its incidence."""
        profile = self._profile
        incidence = np.arccos(np.minimum(cosine, 1.0))
        share = (incidence - profile.specular_from) * self._slope
        loss = np.minimum(np.maximum(share, 0.0), 1.0) * profile.specular_loss
        odds: list[float] = loss.tolist()
        return odds

    def _disturb(self, echoes: list[float]) -> list[float]:
        """Add noise and outliers; what is nearer than the nearest reads as the nearest."""
        profile = self._profile
        odds, places = self._random.random((2, len(echoes))).tolist()
        errors = self._random.standard_normal(len(echoes)).tolist()
        readings = []
        for echo, odd, place, error in zip(echoes, odds, places, errors, strict=True):
            known = 0.0 if math.isinf(echo) else echo
            reading = echo + (profile.noise + profile.noise_share * known) * error
            if odd < profile.outliers:
                reading = profile.nearest + place * (profile.farthest - profile.nearest)
            too_far = reading > profile.farthest
            readings.append(math.inf if too_far else max(reading, profile.nearest))
        return readings
