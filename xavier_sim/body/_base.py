"""The synchro-drive base: commands become velocities within what the motors can do."""

from __future__ import annotations

import math

from xavier_sim.profile import PHYSICS_STEP, BaseProfile


def clip_command(base: BaseProfile, speed: float, turn_rate: float) -> tuple[float, float]:
    """The command within the base's limits; one that is no number counts as zero."""
    return _clip(speed, base.top_speed), _clip(turn_rate, base.top_turn_rate)


def next_speed(base: BaseProfile, now: float, wanted: float) -> float:
    """The speed one physics step later: braking is quicker than speeding up."""
    slowing = abs(wanted) < abs(now) or wanted * now < 0.0
    return _towards(now, wanted, (base.braking if slowing else base.acceleration) * PHYSICS_STEP)


def next_turn_rate(base: BaseProfile, now: float, wanted: float) -> float:
    """The turn rate one physics step later."""
    return _towards(now, wanted, base.turn_acceleration * PHYSICS_STEP)


def _towards(now: float, wanted: float, most: float) -> float:
    return now + min(max(wanted - now, -most), most)


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit) if math.isfinite(value) else 0.0
