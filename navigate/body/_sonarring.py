"""What the navigator knows about the robot's body and its sonars."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from navigate.maps import Floats
from xavier_sim.messages import BUMP_PANELS, LIDAR_BEAMS, SONAR_COUNT, STRIPER_BEAMS, Sensors

ROBOT_RADIUS = 0.305
"""Metres."""

RING_RADIUS = 0.25
"""Metres from the robot's centre to the sonars, from which readings count."""

NEAREST = 0.2
"""The shortest reading, metres: what is nearer reads the same."""

CONE_HALF = math.radians(11.25)
"""Half the opening of a sonar's cone."""

PITCH = 2.0 * math.pi / SONAR_COUNT
"""Radians from one sonar to the next."""

BEARINGS: Floats = PITCH * np.arange(SONAR_COUNT, dtype=np.float64)
"""Where each sonar looks, radians to the left of ahead, shape (24,)."""

SONARS = range(SONAR_COUNT)

FASTEST, FASTEST_TURN = 10.0, 20.0
"""A reading that says that the robot drives faster than this, in m/s and rad/s, is wrong."""

FARTHEST_ODOM = 1e5
"""Metres or radians beyond which odometry says nothing: its own numbers are too coarse there."""

_BYTES = np.array([1, 1 << 8, 1 << 16], dtype=np.int64)


def wrap(angle: float) -> float:
    """The same angle in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def fault_of(sensors: Sensors) -> str | None:
    """What makes a reading useless, as a sentence; None when it is sound."""
    return _fault_of_ranges(sensors) or _fault_of_motion(sensors)


def _fault_of_ranges(sensors: Sensors) -> str | None:
    if sensors.sonar.shape != (SONAR_COUNT,):
        return f"sonar has {sensors.sonar.size} readings, expected {SONAR_COUNT}"
    for name, ranges, beams in (
        ("striper", sensors.striper, STRIPER_BEAMS),
        ("lidar", sensors.lidar, LIDAR_BEAMS),
    ):
        if ranges.shape not in {(0,), (beams,)}:
            return f"{name} has {ranges.size} readings, expected {beams} or none, in one row"
    # The least of the numbers is no number where there is none.
    if math.isnan(np.fmin.reduce(sensors.sonar)):
        return f"sonar has no number among its {SONAR_COUNT} readings"
    return None


def _fault_of_motion(sensors: Sensors) -> str | None:
    if sensors.odom.shape != (3,) or not (np.abs(sensors.odom) <= FARTHEST_ODOM).all():
        return (
            f"odom is {sensors.odom.tolist()}, expected three numbers "
            f"from -{FARTHEST_ODOM:g} to {FARTHEST_ODOM:g}"
        )
    for name, seconds in (("time", sensors.time), ("period", sensors.period)):
        if not math.isfinite(seconds):
            return f"{name} is {seconds}, expected a finite number"
    if not abs(sensors.speed) <= FASTEST:
        return f"speed is {sensors.speed:g} m/s, expected -{FASTEST:g} to {FASTEST:g}"
    if not abs(sensors.turn_rate) <= FASTEST_TURN:
        limit = f"-{FASTEST_TURN:g} to {FASTEST_TURN:g}"
        return f"turn_rate is {sensors.turn_rate:g} rad/s, expected {limit}"
    return None


def heard_ranges(sensors: Sensors) -> Floats:
    """The sonar readings, shape (24,), metres; what is no range counts as no echo."""
    ranges = sensors.sonar.astype(np.float64)
    return np.where(ranges >= 0.0, ranges, np.inf)


@functools.lru_cache(maxsize=256)
def fresh_sonars(bits: int) -> tuple[int, ...]:
    """The numbers of the sonars whose bit is set."""
    return tuple(number for number in SONARS if bits >> number & 1)


@functools.lru_cache(maxsize=256)
def sonars_of(bits: int) -> NDArray[np.intp]:
    """The numbers of the sonars whose bit is set, as an index that is not to be changed."""
    sonars = np.array(fresh_sonars(bits), dtype=np.intp)
    sonars.setflags(write=False)
    return sonars


@functools.lru_cache(maxsize=256)
def mask_of(bits: int) -> NDArray[np.bool_]:
    """Whether the bit of each sonar is set, shape (24,), not to be changed."""
    mask = np.zeros(SONAR_COUNT, dtype=np.bool_)
    mask[sonars_of(bits)] = True
    mask.setflags(write=False)
    return mask


def bits_of(sonars: NDArray[np.bool_]) -> int:
    """The bits of the sonars that are true in an array of shape (24,)."""
    return int(np.packbits(sonars, bitorder="little").view(np.uint8) @ _BYTES)


def bump_direction(panels: int) -> float | None:
    """The mean direction of the panels pressed, radians to the left of ahead; None when none is."""
    angles = [i * 2.0 * math.pi / BUMP_PANELS for i in range(BUMP_PANELS) if panels >> i & 1]
    if not angles:
        return None
    return math.atan2(sum(map(math.sin, angles)), sum(map(math.cos, angles)))
