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
    """Where the navigator believes the robot to be; ``entropy`` in bits.

    ``goal_mass`` is the share of belief at the goal of a drive, 0 to 1; None without one.
    """

    model_config = ConfigDict(frozen=True)

    position: BelievedPose
    entropy: float
    lost: bool
    goal_mass: float | None = None
    cells: tuple[BelievedCell, ...]


class Belief(Broadcast):
    """The belief, as the navigator broadcasts it."""

    wire_name = "navigateBelief"

    state: BeliefState


class DriveState(BaseModel):
    """How a drive goes: the id of its task, its goal in map units (cm), metres and seconds.

    What is left is along the route, None while there is none; ``goal_mass`` is the share of belief
    at the goal, 0 to 1.
    """

    model_config = ConfigDict(frozen=True)

    task: str
    x: float
    y: float
    room: str | None = None
    metres_left: float | None = None
    seconds_left: float | None = None
    metres: float
    seconds: float
    recoveries: int
    goal_mass: float
    lost: bool = False
    faults: dict[str, str] = {}


class Progress(Broadcast):
    """How the drive under way goes, as the navigator broadcasts it."""

    wire_name = "navigateProgress"

    drive: DriveState
