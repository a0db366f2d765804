"""What the navigator says, as far as a recording needs it.

The robot knows the navigator by its messages only: these have their names on the bus, and the
fields that are shown; the others are recorded by nobody.
"""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from tca_bus import Broadcast


class BelievedPose(BaseModel):
    """A pose in the map, metres and radians, at a simulated time; ``deviation`` in metres."""

    model_config = ConfigDict(frozen=True)

    x: float
    y: float
    theta: float
    deviation: float
    time: float


class BelievedCell(BaseModel):
    """A pose with its share of the belief, 0 to 1."""

    model_config = ConfigDict(frozen=True)

    x: float
    y: float
    theta: float
    mass: float


class BeliefState(BaseModel):
    """Where the navigator believes the robot to be; ``entropy`` in bits."""

    model_config = ConfigDict(frozen=True)

    position: BelievedPose
    entropy: float
    lost: bool
    cells: tuple[BelievedCell, ...]


class Belief(Broadcast):
    """The belief, as the navigator broadcasts it."""

    wire_name = "navigateBelief"

    state: BeliefState
