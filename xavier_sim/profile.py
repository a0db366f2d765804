"""What Xavier's body and sensors are like: the numbers behind the simulated robot."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from xavier_sim.messages import (
    LIDAR_BEAMS,
    LIDAR_FARTHEST,
    LIDAR_VIEW,
    SONAR_CONE,
    SONAR_COUNT,
    SONAR_FARTHEST,
    SONAR_NEAREST,
    SONAR_RING_RADIUS,
    STRIPER_AHEAD,
    STRIPER_BEAMS,
    STRIPER_FARTHEST,
    STRIPER_NEAREST,
    STRIPER_VIEW,
    ProfileName,
)

PHYSICS_STEP = 0.02
"""Seconds of one physics step."""

TICK = 0.1
"""Seconds of one control tick: five physics steps."""

STEPS_PER_TICK = 5


XAVIER_CRUISE = 0.5
"""Metres per second at which a driving robot needs twice the current of a standing one."""


Share = Annotated[float, Field(ge=0.0, le=1.0)]


class BaseProfile(BaseModel):
    """A base on wheels, by default the RWI B24 synchro-drive: SI units."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    radius: float = 0.305
    mass: float = 100.0
    top_speed: float = 0.7
    top_turn_rate: float = 1.5
    acceleration: float = 0.7
    braking: float = 1.4
    turn_acceleration: float = 3.0
    """Of a synchro drive; a differential one turns as its wheels accelerate."""
    track: float | None = Field(default=None, gt=0.0)
    """Metres between the two wheels of a differential drive; None for a synchro drive."""


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
    slips_per_metre: float = 0.0
    """How often the wheels lose their grip for a moment, on a threshold or a cable."""
    slip_metres: float = 0.15
    """What they count wrongly then over the way that follows, metres."""
    slip_turn: float = math.radians(4.0)
    """Radians that the heading jumps then."""
    slip: float = 0.3
    """Share of the motion that a wall prevented and the wheels report all the same."""


class SonarProfile(BaseModel):
    """The Denning ring: 24 cones; metres and radians."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    ring_radius: float = Field(default=SONAR_RING_RADIUS, ge=0.0, le=0.4)
    cone: float = Field(default=SONAR_CONE, gt=0.0, le=math.pi)
    rays: int = Field(default=5, ge=1, le=201)
    nearest: float = Field(default=SONAR_NEAREST, ge=0.0)
    farthest: float = Field(default=SONAR_FARTHEST, gt=0.0, le=100.0)
    noise: float = Field(default=0.015, ge=0.0)
    noise_share: float = Field(default=0.01, ge=0.0)
    specular_from: float = math.radians(55.0)
    """Incidence from which echoes begin to be lost."""
    specular_to: float = math.radians(75.0)
    """Incidence from which nearly all are."""
    specular_loss: Share = 0.9
    specular_whole: bool = False
    """Whether the rays of a cone are lost together, as on a smooth wall, not one by one."""
    outliers: Share = 0.01
    crosstalk: Share = 0.0
    """Share of the pings of a neighbour, fired at the same time, that a sonar takes for its own."""
    phases: int = Field(default=4, ge=1, le=SONAR_COUNT)
    """One of so many parts of the ring fires at each tick."""

    @model_validator(mode="after")
    def _loses_more_from_farther_askew(self) -> Self:
        if not self.specular_from < self.specular_to:
            raise ValueError(
                f"specular_to: expected more than specular_from, {self.specular_from:g}, "
                f"got {self.specular_to:g}"
            )
        return self


class LaserProfile(BaseModel):
    """What measures range by light in evenly spread beams; metres and radians, shares 0 to 1.

    By default the light striper of Nomadics: a camera that sees where a laser's stripe falls. Its
    range comes from triangulation, so its error grows with the square of the range.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    beams: int = Field(default=STRIPER_BEAMS, ge=2, le=2048)
    view: float = Field(default=STRIPER_VIEW, gt=0.0, le=2.0 * math.pi)
    """Radians between the first beam and the last, straight ahead in the middle."""
    ahead: float = STRIPER_AHEAD
    """Metres from the robot's centre to the laser."""
    nearest: float = Field(default=STRIPER_NEAREST, ge=0.0)
    """What is nearer is not seen."""
    farthest: float = Field(default=STRIPER_FARTHEST, gt=0.0, le=100.0)
    noise: float = Field(default=0.003, ge=0.0)
    noise_square: float = Field(default=0.005, ge=0.0)
    """Metres of error per square metre of range."""
    dropouts: Share = 0.02
    dropout_growth: Share = 0.08
    """Share of the beams that are lost on top of that at the farthest range."""
    most_askance: float = math.radians(80.0)
    """Incidence beyond which too little light comes back."""


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
    sonar: SonarProfile | None = SonarProfile()
    """None for a robot without a ring: its lidar stands in, the nearest beam of each cone."""
    striper: LaserProfile | None = None
    lidar: LaserProfile | None = None
    camera: CameraProfile = CameraProfile()
    battery: BatteryProfile | None = None
    """None for a robot that never needs charging."""

    @model_validator(mode="after")
    def _senses_all_round(self) -> Self:
        if self.sonar is None and self.lidar is None:
            raise ValueError("sonar: expected sonars where there is no lidar, got none")
        return self


XAVIER = RobotProfile(striper=LaserProfile())
"""Xavier as the papers describe it, on a good day."""

LIDAR = LaserProfile(
    beams=LIDAR_BEAMS,
    view=LIDAR_VIEW,
    ahead=0.0,
    nearest=0.05,
    farthest=LIDAR_FARTHEST,
    noise=0.01,
    noise_square=0.0,
    dropouts=0.005,
    dropout_growth=0.01,
    most_askance=math.radians(88.0),
)
"""A scanner that measures the time of flight, as robots have since about 2000."""

HARD = RobotProfile(
    odometry=OdometryProfile(slips_per_metre=0.02),
    sonar=SonarProfile(
        rays=11,
        noise=0.02,
        noise_share=0.02,
        specular_from=math.radians(35.0),
        specular_to=math.radians(55.0),
        specular_loss=0.95,
        specular_whole=True,
        outliers=0.02,
        crosstalk=0.02,
        phases=5,
    ),
    striper=LaserProfile(),
)
"""Xavier as unkind as the papers say that it was."""

MODERN = RobotProfile(
    base=BaseProfile(track=0.45),
    odometry=OdometryProfile(
        scale_bias=0.005,
        drift_bias=math.radians(0.15),
        distance_noise=0.005,
        drift_noise=math.radians(0.3),
        turn_noise=math.radians(0.6),
    ),
    sonar=None,
    lidar=LIDAR,
)
"""A robot of today on the same floor."""

PROFILES: dict[ProfileName, RobotProfile] = {"hard": HARD, "modern": MODERN, "xavier": XAVIER}
"""The robots that a command line can name."""
