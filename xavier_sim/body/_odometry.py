"""Dead reckoning that drifts: what the wheels say, which is not where the robot is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import OdometryProfile

SLIP_SHARE = 1.0
"""Metres that slipping wheels count too much or too little for each metre that is driven."""


class Odometry:
    """Integrates motion with errors of scale and drift, noise, and jumps at bumps.

    The estimate is in the odometry frame, which starts at zero where the robot starts.
    """

    def __init__(self, profile: OdometryProfile, seed: int) -> None:
        self._profile = profile
        self._random = stream(seed, "odometry")
        draw = self._random.standard_normal
        self._scale = 1.0 + profile.scale_bias * float(draw())
        self._drift = profile.drift_bias * float(draw())
        self._turn_scale = 1.0 + profile.turn_bias * float(draw())
        self.x, self.y, self.theta = 0.0, 0.0, 0.0
        self.slipping = 0.0
        self._mishaps = stream(seed, "slips")

    def slip(self, metres: float, turn: float) -> None:
        """Count ``metres`` too much from now on (too little when negative), and turn at once.

        The wheels slip for as long as it takes: by `SLIP_SHARE` of the way that is driven.
        """
        self.slipping += metres
        self.theta = wrap(self.theta + turn)

    def move(self, distance: float, turn: float) -> None:
        """Take in what the wheels turned in one control tick: metres ahead, radians."""
        self._slip_by_chance(abs(distance))
        profile, draw = self._profile, self._random.standard_normal(3).tolist()
        root = math.sqrt(abs(distance))
        noise = profile.distance_noise * root * draw[0]
        seen = distance * self._scale + noise + self._slipped(distance)
        seen_turn = turn * self._turn_scale + self._drift * abs(distance)
        seen_turn += profile.turn_noise * math.sqrt(abs(turn)) * draw[1]
        seen_turn += profile.drift_noise * root * draw[2]
        middle = self.theta + seen_turn / 2
        self.x += seen * math.cos(middle)
        self.y += seen * math.sin(middle)
        self.theta = wrap(self.theta + seen_turn)

    def _slip_by_chance(self, metres: float) -> None:
        often = self._profile.slips_per_metre * metres
        if often > 0.0 and self._mishaps.random() < often:
            metres_off, turn_off = self._mishaps.standard_normal(2)
            profile = self._profile
            self.slip(profile.slip_metres * float(metres_off), profile.slip_turn * float(turn_off))

    def _slipped(self, distance: float) -> float:
        """What the wheels count too much over a true ``distance``, metres."""
        most = SLIP_SHARE * abs(distance)
        error = max(-most, min(most, self.slipping))
        self.slipping -= error
        return math.copysign(1.0, distance) * error if distance else 0.0

    def jolt(self) -> None:
        """Jump a little, as wheels do that were knocked."""
        draw = self._random.standard_normal(3)
        self.x += self._profile.bump_jump * float(draw[0])
        self.y += self._profile.bump_jump * float(draw[1])
        self.theta = wrap(self.theta + self._profile.bump_turn * float(draw[2]))

    def pose(self) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
        """x, y in metres and theta in radians, shape (3,)."""
        return np.array([self.x, self.y, self.theta], dtype=np.float32)

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs, as plain numbers."""
        return {
            "pose": [self.x, self.y, self.theta],
            "errors": [self._scale, self._drift, self._turn_scale],
            "slipping": self.slipping,
            "random": stream_state(self._random),
            "mishaps": stream_state(self._mishaps),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.x, self.y, self.theta = state["pose"]
        self.slipping = state.get("slipping", 0.0)
        self._scale, self._drift, self._turn_scale = state["errors"]
        restore_stream(self._random, state["random"])
        if "mishaps" in state:
            restore_stream(self._mishaps, state["mishaps"])


def wrap(angle: float) -> float:
    """The same angle in (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)
