"""Faults that are made on command, for people who try the robot, and for tests."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tca_bus import Query
from xavier_sim.messages.robot import SONAR_COUNT, SONAR_FARTHEST

Metres = Annotated[float, Field(allow_inf_nan=False)]


class _Fault(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Kidnap(_Fault):
    """The robot is put down elsewhere, standing, and its odometry does not notice.

    To the place of a ``room``, or to ``x`` and ``y`` in metres; or by ``ahead`` metres along its
    heading and ``left`` metres across. It looks where it looked before, or along ``theta``.
    """

    kind: Literal["kidnap"] = "kidnap"
    room: str | None = Field(default=None, max_length=64)
    x: Metres | None = None
    y: Metres | None = None
    ahead: Metres = 0.0
    left: Metres = 0.0
    theta: Metres | None = None

    @model_validator(mode="after")
    def _names_one_place(self) -> Self:
        if (self.x is None) != (self.y is None):
            raise ValueError("expected both x and y, or neither")
        moved = (self.ahead, self.left) != (0.0, 0.0)
        if sum((self.room is not None, self.x is not None, moved)) != 1:
            raise ValueError("expected a room, or x and y, or ahead and left")
        return self


class Slip(_Fault):
    """Dead reckoning goes wrong.

    The wheels slip: over the way that the odometry counts next it counts ``metres`` more than
    were driven (fewer when negative). ``turn`` radians are added to its heading at once.
    """

    kind: Literal["odometry"] = "odometry"
    metres: float = Field(default=0.0, ge=-50.0, le=50.0)
    turn: float = Field(default=0.0, ge=-3.2, le=3.2)


class CameraPower(_Fault):
    """The camera is gone, or back."""

    kind: Literal["camera"] = "camera"
    on: bool


class SonarFault(_Fault):
    """A sonar hears nothing any more, always reads the same, or is sound again.

    A stuck one reads ``metres`` from its next ping on, or what it read last.
    """

    kind: Literal["sonar"] = "sonar"
    number: int = Field(ge=0, lt=SONAR_COUNT)
    state: Literal["dead", "stuck", "sound"]
    metres: float | None = Field(default=None, ge=0.0, le=SONAR_FARTHEST)

    @model_validator(mode="after")
    def _is_stuck_somewhere(self) -> Self:
        if self.metres is not None and self.state != "stuck":
            raise ValueError(f"expected no metres for a {self.state} sonar, not {self.metres:g}")
        return self


class LaserOffset(_Fault):
    """Striper and lidar were knocked: they measure so much too far, and look askew.

    ``metres`` too far (too near when negative), ``turn`` radians to the left of where they should
    look. It holds until another offset takes its place; with both zero they are sound.
    """

    kind: Literal["laser"] = "laser"
    metres: float = Field(default=0.0, ge=-1.0, le=1.0)
    turn: float = Field(default=0.0, ge=-0.5, le=0.5)


class WheelSlip(_Fault):
    """A wheel slips until it is mended, with a share of 0.

    Of what the wheels turn, ``share`` moves the robot nowhere; it turns by ``veer`` radians,
    counter-clockwise, for each metre that the wheels turn. The odometry notices neither.
    """

    kind: Literal["wheels"] = "wheels"
    share: float = Field(default=0.0, ge=0.0, le=0.8)
    veer: float = Field(default=0.0, ge=-0.5, le=0.5)


class Mend(_Fault):
    """All that was broken on command is sound again; a robot that was moved stays there."""

    kind: Literal["mend"] = "mend"


AnyFault = Annotated[
    Kidnap | Slip | CameraPower | SonarFault | LaserOffset | WheelSlip | Mend,
    Field(discriminator="kind"),
]


class FaultState(BaseModel):
    """What is wrong with the robot.

    ``slip`` is what the odometry has still to count wrongly, metres; ``room`` and ``space`` where
    the robot really stands. ``sonars`` are those that are not sound.
    """

    model_config = ConfigDict(frozen=True)

    camera_on: bool
    slip: float
    room: str | None
    space: str | None
    tick: int
    time: float
    sonars: tuple[SonarFault, ...] = ()
    laser: LaserOffset = LaserOffset()
    wheels: WheelSlip = WheelSlip()


class Fault(Query[FaultState]):
    """Make a fault at this very tick. Fails with ``unknown_room``, ``not_free``, ``no_sensor``."""

    wire_name = "xavierFault"

    fault: AnyFault


class ReadFaults(Query[FaultState]):
    """Ask what is wrong with the robot."""

    wire_name = "xavierFaults"
