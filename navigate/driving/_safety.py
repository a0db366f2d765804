"""Reactive safety: stop the wheels within the tick, whatever the driver wants."""

from __future__ import annotations

import math

import numpy as np

from navigate.body import BEARINGS, NEAREST, RING_RADIUS, ROBOT_RADIUS
from navigate.driving._view import STOP, View, Wheels
from xavier_sim.messages import SONAR_COUNT, Sensors

BRAKES = 1.0
"""Metres per second squared that the base can brake for sure."""

KEEP_OFF = 0.06
"""Metres to keep from what is ahead, at any speed."""

NARROW_KEEP_OFF = 0.02

GENTLE = 0.1
"""Metres per second at which the robot may touch somebody."""

TOUCHING = NEAREST + 0.03
"""A reading below this may come from what is as near as can be."""

BLIND_SPEED = 0.3
"""Metres per second at most forward when only its neighbours stand in for the sonar ahead."""

REAR = SONAR_COUNT // 2
"""The sonar that looks straight back."""


def guard(wheels: Wheels, view: View) -> Wheels:
    """Let ``wheels`` through, or no more of their speed than there is room to brake in.

    A contact on the side that the robot drives to stops it at once.
    """
    if view.bump and _pushes(view.bump, wheels.speed):
        return STOP
    if wheels.speed == 0.0:
        return wheels
    if wheels.speed > BLIND_SPEED and view.is_blind(0):
        wheels = wheels._replace(speed=BLIND_SPEED)
    room = _room_on(view, narrow=wheels.narrow, backward=wheels.speed < 0.0)
    if wheels.speed**2 > 2.0 * BRAKES * max(0.0, room):
        return Wheels(0.0, wheels.turn, wheels.narrow)
    if not wheels.narrow and is_touching(view, backward=wheels.speed < 0.0):
        return wheels._replace(speed=max(-GENTLE, min(GENTLE, wheels.speed)))
    return wheels


def must_stop(wheels: Wheels, sensors: Sensors) -> bool:
    """Whether ``wheels``, commanded before, would drive into what this reading touches or hears.

    Needs neither map nor belief nor plan: it can be answered before anything else is thought of.
    Where the sonar ahead hears nothing, it may be dead: what both its neighbours hear counts.
    """
    if sensors.bump and _pushes(sensors.bump, wheels.speed):
        return True
    reading, news = _range(sensors, 0), 1
    if reading == math.inf:
        reading, news = max(_range(sensors, 1), _range(sensors, -1)), _BESIDE_AHEAD
    if wheels.speed <= 0.0 or not sensors.sonar_fresh & news:
        return False
    room = _room(reading, NARROW_KEEP_OFF)
    return wheels.speed**2 > 2.0 * BRAKES * max(0.0, room)


def _range(sensors: Sensors, number: int) -> float:
    """What a sonar reads, metres; what is no range is no echo."""
    reading = float(sensors.sonar[number])
    return reading if reading >= 0.0 else math.inf


def _room_on(view: View, *, narrow: bool, backward: bool) -> float:
    """Metres to the nearest echo in the robot's lane, ahead of it or behind it."""
    if narrow:
        return _room(float(view.ranges[REAR if backward else 0]), NARROW_KEEP_OFF)
    ahead, left = view.echoes[:, 0] * (-1.0 if backward else 1.0), view.echoes[:, 1]
    lane = (ahead > 0.0) & (np.abs(left) < ROBOT_RADIUS)
    nearest = float(ahead[lane].min(initial=np.inf))
    return _room(nearest - RING_RADIUS, KEEP_OFF)


def is_touching(view: View, *, backward: bool) -> bool:
    """Whether something on the side that the robot drives to may touch it at any moment."""
    near = view.ranges[_BACK if backward else _FRONT] < TOUCHING
    return bool(near.any())


_BESIDE_AHEAD = 0b10 | 1 << SONAR_COUNT - 1
_FRONT = np.flatnonzero(np.cos(BEARINGS) > 0.2)
_BACK = np.flatnonzero(np.cos(BEARINGS) < -0.2)


def _room(reading: float, keep: float) -> float:
    """Metres left before what a sonar ahead reads; the shortest reading may mean any less."""
    if reading < NEAREST + 0.02:
        return 0.0
    return RING_RADIUS + reading - ROBOT_RADIUS - keep


def _pushes(panels: int, speed: float) -> bool:
    """Whether a pressed panel lies on the side that ``speed`` drives to (panel 0 is ahead)."""
    front, back = 0b10000011, 0b00111000
    return bool(panels & (front if speed > 0.0 else back if speed < 0.0 else 0xFF))
