"""What the base and its sensors say and hear, and where the robot really is.

Frames and units follow REP-103 and REP-105: metres, seconds, radians counter-clockwise,
x forward, y left; ``odom`` is continuous and drifts, ``map`` does not.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Broadcast, Inform, Query
from tca_bus.arrays import Float32Array

SONAR_COUNT = 24
"""Sonars on Xavier's ring: number i looks ``i * 15`` degrees to the left of straight ahead."""

SONAR_RING_RADIUS = 0.25
"""Metres from the robot's centre to its sonars: readings start there."""

SONAR_CONE = math.radians(22.5)
"""Opening of a sonar's cone, radians: the nearest echo in it is the reading."""

SONAR_NEAREST = 0.2
"""A reading is never smaller, metres: what is nearer reads as this."""

SONAR_FARTHEST = 6.5
"""A reading is never greater, metres, but for ``inf``: no echo."""

STRIPER_BEAMS = 31
"""Beams of the light striper: one a degree, from the right to the left."""

STRIPER_VIEW = math.radians(30.0)
"""Radians from the striper's first beam to its last; the middle one looks straight ahead."""

STRIPER_AHEAD = 0.25
"""Metres from the robot's centre to the striper: readings start there."""

STRIPER_NEAREST = 0.3
"""What is nearer to the striper is not seen, metres."""

STRIPER_FARTHEST = 3.0
"""What is farther from the striper is not seen, metres."""

LIDAR_BEAMS = 180
"""Beams of a lidar: number i looks ``i * 2 - 179`` degrees to the left of straight ahead."""

LIDAR_VIEW = math.radians(358.0)
"""Radians from the lidar's first beam to its last; readings start at the robot's centre."""

LIDAR_FARTHEST = 8.0
"""What is farther from the lidar is not seen, metres."""

BUMP_PANELS = 8
"""Bump panels round the base: panel i is centred ``i * 45`` degrees to the left of ahead."""


def _nothing() -> NDArray[np.float32]:
    return np.empty(0, dtype=np.float32)


class Sensors(Broadcast):
    """All that the robot senses at one control tick.

    ``sonar`` has shape (24,), metres from the ring (`SONAR_RING_RADIUS` off the centre), ``inf``
    where no echo came back; a reading is new when its bit in ``sonar_fresh`` is set. ``odom``
    has shape (3,): x, y in metres and theta in radians in the odometry frame. With ``lockstep``
    set the world waits for a `Drive` that answers this ``tick``.

    ``striper`` and ``lidar`` are metres along beams that are spread evenly over `STRIPER_VIEW` and
    `LIDAR_VIEW`, from the right to the left; ``inf`` where nothing was seen. They are empty on a
    robot that has none. On one with a lidar and no sonars ``sonar`` tells the nearest beam in
    each cone.
    """

    wire_name = "xavierSensors"

    tick: int = Field(ge=0)
    time: float
    period: float = Field(gt=0)
    lockstep: bool
    sonar: Float32Array
    sonar_fresh: int = Field(ge=0, lt=1 << SONAR_COUNT)
    odom: Float32Array
    speed: float
    turn_rate: float
    bump: int = Field(ge=0, lt=1 << BUMP_PANELS)
    striper: Float32Array = Field(default_factory=_nothing)
    lidar: Float32Array = Field(default_factory=_nothing)


class Drive(Inform):
    """Velocities for the synchro-drive base, as the answer to the sensors of ``tick``.

    ``speed`` in m/s, ``turn_rate`` in rad/s, counter-clockwise positive. ``busy`` says that the
    driver has a goal; while nobody is busy, simulated time at full speed moves only for those
    who wait on the clock.
    """

    wire_name = "xavierDrive"

    tick: int = Field(ge=0)
    speed: float = Field(ge=-2.0, le=2.0)
    turn_rate: float = Field(ge=-4.0, le=4.0)
    busy: bool


class TrueLocation(BaseModel):
    """Where the robot really is; the simulator knows, the robot does not.

    ``room`` is the room in or before whose door it stands, if any. ``metres`` is the distance
    driven since the world began, ``bumps`` the number of contacts, ``time`` simulated seconds
    since the epoch. ``people_touched`` counts the contacts with people, ``people_hit`` those in
    which the robot came towards them faster than 0.1 m/s, ``hardest_hit`` is the fastest, m/s.
    """

    model_config = ConfigDict(frozen=True)

    x: float
    y: float
    theta: float
    room: str | None
    space: str | None
    metres: float
    bumps: int
    tick: int
    time: float
    people_touched: int = 0
    people_hit: int = 0
    hardest_hit: float = 0.0


class WhereReally(Query[TrueLocation]):
    """Ask the simulator for the truth: for people who look, and for tests."""

    wire_name = "xavierTrueLocation"
