"""What Xavier's body and sensors are like: the numbers behind the simulated robot."""

from __future__ import annotations

import math

from pydantic import BaseModel, ConfigDict, Field

from xavier_sim.messages import SONAR_CONE, SONAR_FARTHEST, SONAR_NEAREST, SONAR_RING_RADIUS

PHYSICS_STEP = 0.02
"""Seconds of one physics step."""

TICK = 0.1
"""Seconds of one control tick: five physics steps."""

STEPS_PER_TICK = 5


XAVIER_CRUISE = 0.5
"""Metres per second at which a driving robot needs twice the current of a standing one."""


class BaseProfile(BaseModel):
    """The RWI B24 synchro-drive base: SI units."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    radius: float = 0.305
    mass: float = 100.0
    top_speed: float = 0.7
    top_turn_rate: float = 1.5
    acceleration: float = 0.7
    braking: float = 1.4
    turn_acceleration: float = 3.0


class OdometryProfile(BaseModel):
    """Errors of dead reckoning.

    Biases are drawn once for a world, noise goes with the square root of what was travelled.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    scale_bias: float = 0.015
    """Metres per metre."""
    drift_bias: float = math.radians(0.4)
    """Radians of heading per metre."""
    turn_bias: float = 0.01
    """Radians per radian."""
    distance_noise: float = 0.01
    """Metres per square root of a metre."""
    drift_noise: float = math.radians(0.6)
    """Radians of heading per square root of a metre."""
    turn_noise: float = math.radians(1.0)
    """Radians per square root of a radian."""
    bump_jump: float = 0.02
    """Metres that the estimate jumps at a bump, in x and in y."""
    bump_turn: float = math.radians(1.0)
    """Radians that the heading jumps at a bump."""
    slip: float = 0.3
    """Share of the motion that a wall prevented and the wheels report all the same."""


class SonarProfile(BaseModel):
    """The Denning ring: 24 cones; metres and radians."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    ring_radius: float = SONAR_RING_RADIUS
    cone: float = SONAR_CONE
    rays: int = 5
    nearest: float = SONAR_NEAREST
    farthest: float = SONAR_FARTHEST
    noise: float = 0.015
    noise_share: float = 0.01
    specular_from: float = math.radians(55.0)
    """Incidence from which echoes begin to be lost."""
    specular_to: float = math.radians(75.0)
    """Incidence from which nearly all are."""
    specular_loss: float = 0.9
    outliers: float = 0.01
    phases: int = 4
    """One of so many parts of the ring fires at each tick."""


class CameraProfile(BaseModel):
    """The colour camera on its pan-tilt head: metres and radians, shares from 0 to 1.

    What is seen worse, from farther or more askance, has a *badness* of 0 to 2; the shares of
    plates that are not found, or misread, grow with it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    nearest: float = 0.3
    farthest: float = 2.0
    most_askance: float = math.radians(60.0)
    pan: float = math.radians(159.0)
    """How far the head turns to either side."""
    blank: float = 0.02
    blank_growth: float = 0.08
    misread: float = 0.01
    misread_growth: float = 0.04


class BatteryProfile(BaseModel):
    """What the battery lasts for: seconds of standing, or metres on top of that.

    Xavier ran a few hours a day; by default it runs here for four hours standing, two driving.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    standing_seconds: float = Field(default=4 * 3600.0, gt=0.0)
    metres: float = Field(default=4 * 3600.0 * XAVIER_CRUISE, gt=0.0)
    charging_seconds: float = Field(default=3600.0, gt=0.0)
    low: float = 0.2
    charger_reach: float = 0.5
    """Metres from the charger within which a standing robot is charged."""


class RobotProfile(BaseModel):
    """The whole robot."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    base: BaseProfile = BaseProfile()
    odometry: OdometryProfile = OdometryProfile()
    sonar: SonarProfile = SonarProfile()
    camera: CameraProfile = CameraProfile()
    battery: BatteryProfile | None = None
    """None for a robot that never needs charging."""


XAVIER = RobotProfile()
"""Xavier as the papers describe it."""
