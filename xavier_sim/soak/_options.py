"""What a soak is made of: everything on which its course depends."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from xavier_sim.floors import DEFAULT_FLOOR
from xavier_sim.messages import ProfileName
from xavier_sim.sensors import Rays
from xavier_sim.soak._mishaps import FaultKind

Share = Annotated[float, Field(ge=0.0, le=1.0)]


class SoakOptions(BaseModel):
    """The same options give the same soak, bit for bit.

    ``survey_sigma`` is the standard deviation in metres of the errors of walls and doors in the
    map that the navigator is given. Every door is shut for ``shut_share`` of the time, and looked
    at by somebody ``door_moves_per_hour`` times. With ``doors_in_and_out`` the robot is sent into
    every room and out again so many times, instead of anywhere at random. Between two jobs it
    stands for ``rest`` seconds.

    ``rays`` says what casts the rays of the sensors, and changes nothing of the soak but its pace.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    seed: int = Field(default=0, ge=0)
    floor: str = DEFAULT_FLOOR
    navigator: str = "navigate"
    navigator_options: dict[str, str] = {}
    profile: ProfileName = "xavier"
    people: int = Field(default=0, ge=0, le=200)
    carts: int = Field(default=0, ge=0, le=200)
    fault: FaultKind | None = None
    survey_sigma: float = Field(default=0.03, ge=0.0, le=0.2)
    shut_share: Share = 0.1
    door_moves_per_hour: float = Field(default=1.0, ge=0.0, le=3600.0)
    doors_in_and_out: int = Field(default=0, ge=0, le=1000)
    rest: float = Field(default=2.0, ge=0.0, le=3600.0)
    rays: Rays = "auto"

    def differences(self, other: SoakOptions) -> dict[str, tuple[object, object]]:
        """The fields in which two differ that make another soak, with both values."""
        mine, others = self.model_dump(exclude={"rays"}), other.model_dump(exclude={"rays"})
        return {name: (mine[name], others[name]) for name in mine if mine[name] != others[name]}
