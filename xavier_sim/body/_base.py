"""The base: commands become velocities within what its motors can do."""

from __future__ import annotations

import math

from xavier_sim.profile import PHYSICS_STEP, BaseProfile

Velocities = tuple[float, float]
"""Speed along the heading in m/s, and turn rate in rad/s, counter-clockwise positive."""


def clip_command(base: BaseProfile, speed: float, turn_rate: float) -> Velocities:
    """The command within the base's limits; one that is no number counts as zero.

    A differential drive that cannot turn its outer wheel so fast keeps the curvature.
    """
    wanted = _clip(speed, base.top_speed), _clip(turn_rate, base.top_turn_rate)
    if base.track is None:
        return wanted
    fastest = max(abs(wheel) for wheel in _wheels(base.track, wanted))
    share = min(1.0, base.top_speed / fastest) if fastest > 0.0 else 1.0
    return wanted[0] * share, wanted[1] * share


def next_velocities(base: BaseProfile, now: Velocities, wanted: Velocities) -> Velocities:
    """The velocities one physics step later: braking is quicker than speeding up.

    A synchro drive speeds up and turns independently. The wheels of a differential drive change
    their speeds in proportion, as fast as the slower to change can.
    """
    if base.track is None:
        turn_step = base.turn_acceleration * PHYSICS_STEP
        speed = _towards(now[0], wanted[0], _most_step(base, now[0], wanted[0]))
        return speed, _towards(now[1], wanted[1], turn_step)
    share = 1.0
    for wheel, aim in zip(_wheels(base.track, now), _wheels(base.track, wanted), strict=True):
        if aim != wheel:
            share = min(share, _most_step(base, wheel, aim) / abs(aim - wheel))
    return now[0] + share * (wanted[0] - now[0]), now[1] + share * (wanted[1] - now[1])


def _wheels(track: float, velocities: Velocities) -> tuple[float, float]:
    """How fast the left and the right wheel of a differential drive run, m/s."""
    speed, turn_rate = velocities
    return speed - turn_rate * track / 2.0, speed + turn_rate * track / 2.0


def _most_step(base: BaseProfile, now: float, wanted: float) -> float:
    slowing = abs(wanted) < abs(now) or wanted * now < 0.0
    return (base.braking if slowing else base.acceleration) * PHYSICS_STEP


def _towards(now: float, wanted: float, most: float) -> float:
    return now + min(max(wanted - now, -most), most)


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit) if math.isfinite(value) else 0.0
