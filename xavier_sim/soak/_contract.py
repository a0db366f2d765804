"""What a navigator offers to be soaked: structural types, so that it need not know this package."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar, runtime_checkable

from xavier_sim.messages import FloorPlan, Sensors

Pose = tuple[float, float, float]
"""x, y in metres and theta in radians in the map frame."""


class Wheels(Protocol):
    """What a navigator wants of the base: m/s along the heading, rad/s to the left."""

    @property
    def speed(self) -> float:
        """Metres per second."""
        ...

    @property
    def turn(self) -> float:
        """Radians per second."""
        ...


class Failure(Protocol):
    """Why a drive did not arrive."""

    @property
    def reason(self) -> str:
        """A name that can be counted, such as ``door_blocked``."""
        ...


class DriveUnderWay(Protocol):
    """A drive, looked at after every step until it is done."""

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        ...

    @property
    def failure(self) -> Failure | None:
        """Why it ended elsewhere, None for an arrival."""
        ...


class Believed(Protocol):
    """How sure a navigator is of where it stands."""

    @property
    def confidence(self) -> float:
        """The probability that it stands at the room that it names, 0 to 1."""
        ...


class DriveReport(Protocol):
    """What a drive has come to."""

    @property
    def recoveries(self) -> int:
        """Troubles that the navigator met and dealt with by itself."""
        ...

    @property
    def position(self) -> Believed:
        """Where it believes to be."""
        ...


@runtime_checkable
class BlamesDoor(Protocol):
    """A `DriveReport` that also tells whose door has ended the drive."""

    @property
    def door(self) -> str | None:
        """The room that the door belongs to."""
        ...


Drive = TypeVar("Drive", bound=DriveUnderWay)


@runtime_checkable
class NavigatorCore(Protocol[Drive]):
    """The core of a navigator: sensors in, wheels out, goals in between.

    It is called from one thread, once a control tick, and decides nothing by the wall clock.
    """

    @property
    def pose(self) -> Pose:
        """Where it believes to be."""
        ...

    def step(self, sensors: Sensors) -> Wheels:
        """Take in what the robot senses at a tick, and answer with the wheels."""
        ...

    def start(self, goal: tuple[float, float], sensors: Sensors) -> Drive:
        """Begin to drive to a point in metres."""
        ...

    def cancel(self) -> None:
        """Give up the drive under way, and stand."""
        ...

    def report(self, drive: Drive) -> DriveReport:
        """What a drive has come to."""
        ...

    def set_pose(self, pose: Pose) -> None:
        """Believe to be at ``pose``, as somebody said who sees the robot there."""
        ...

    def freeze(self) -> dict[str, Any]:
        """Everything that `thaw` needs to go on bit for bit, as JSON holds it; between drives."""
        ...

    def thaw(self, state: dict[str, Any]) -> None:
        """Go on from a state that `freeze` gave."""
        ...


class NavigatorFactory(Protocol):
    """Makes a navigator for a floor as it was surveyed; options are its own, as text."""

    def __call__(self, plan: FloorPlan, *, seed: int, **options: str) -> NavigatorCore[Any]:
        """A navigator that believes to stand at the start of the plan."""
        ...
