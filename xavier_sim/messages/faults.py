"""Faults that are made on command, for people who try the robot, and for tests."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tca_bus import Query

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
            raise ValueError("x and y: give both or neither")
        moved = (self.ahead, self.left) != (0.0, 0.0)
        if sum((self.room is not None, self.x is not None, moved)) != 1:
            raise ValueError("give a room, or x and y, or ahead and left")
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


AnyFault = Annotated[Kidnap | Slip | CameraPower, Field(discriminator="kind")]


class FaultState(BaseModel):
    """What is wrong with the robot after a fault.

    ``slip`` is what the odometry has still to count wrongly, metres; ``room`` and ``space`` where
    the robot really stands.
    """

    model_config = ConfigDict(frozen=True)

    camera_on: bool
    slip: float
    room: str | None
    space: str | None
    tick: int
    time: float


class Fault(Query[FaultState]):
    """Make a fault at this very tick. Fails with ``unknown_room`` or ``not_free``."""

    wire_name = "xavierFault"

    fault: AnyFault
