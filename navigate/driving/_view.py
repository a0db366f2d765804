"""What a manoeuvre sees at a control tick, what it answers, and what can interrupt it.

A manoeuvre is a generator: it yields `Wheels`, is sent the next `View`, and returns when it is
done. Interrupts are exceptions thrown into it; it may clean up, but not go on regardless.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from navigate.body import Laser, Pose, Sight
from navigate.maps import Floats, Passage, Point

Result = TypeVar("Result")


class Wheels(NamedTuple):
    """Wanted speed in m/s and turn rate in rad/s.

    ``narrow`` says that the robot is in a door, where only what is straight ahead is an
    obstacle: the jambs are meant to be near.
    """

    speed: float
    turn: float
    narrow: bool = False


STOP = Wheels(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class View:
    """One tick as a manoeuvre sees it.

    ``pose`` is believed, in the map frame, ``odom`` is dead reckoning. ``ranges`` has shape
    (24,), metres from the ring, inf for no echo; ``fresh`` holds the bits of new readings, and
    ``renewed`` those of new ones that stand in for a sonar that is not to be believed.
    ``echoes`` are what was heard and seen around lately, shape (n, 2), metres ahead and left, and
    ``spreads`` (n,) the radians to either side within which each may be; a sonar's cone when it is
    None. ``speed`` in m/s and ``turn`` in rad/s are how the wheels move now. ``sights`` are what
    the robot's lasers see that are to be believed. ``advice`` is where a lost robot had best go,
    radians to the left of ahead, as far as its belief says; ``supposed`` says that it had better go
    on as if it were at ``pose``. ``goal_mass`` is the share of its
    belief that lies at the goal, 0 to 1, once it is near; 1 on the way. ``blind`` holds the bits
    of sonars for which no more than their neighbours stand in. ``close_ahead`` says that by raw
    readings, believed or not, something is so near ahead that the base itself may hold the wheels.
    """

    time: float
    pose: Pose
    odom: Pose
    ranges: Floats
    fresh: int
    bump: int
    echoes: Floats
    lost: bool = False
    supposed: bool = False
    advice: float | None = None
    goal_mass: float = 1.0
    speed: float = 0.0
    turn: float = 0.0
    sights: tuple[tuple[Laser, Sight], ...] = ()
    spreads: Floats | None = None
    renewed: int = 0
    blind: int = 0
    close_ahead: bool = False

    @property
    def at(self) -> Point:
        """The believed position."""
        return (self.pose[0], self.pose[1])

    def is_fresh(self, sonar: int) -> bool:
        """Whether the reading of a sonar, or what stands in for it, is new at this tick."""
        return bool((self.fresh | self.renewed) >> sonar & 1)

    def is_blind(self, sonar: int) -> bool:
        """Whether nothing but its neighbours tells what is before a sonar."""
        return bool(self.blind >> sonar & 1)


Manoeuvre = Generator[Wheels, View, Result]


class Trouble(Exception):  # noqa: N818 -- an event on the way, not an error of the program
    """Something that ends a manoeuvre before its goal; the driver decides what comes next."""


class Rerouted(Exception):  # noqa: N818 -- an event on the way as well
    """Another way has become better than the one that is driven."""


class Bumped(Trouble):
    """The robot touched something; ``direction`` is radians to the left of ahead."""

    def __init__(self, direction: float, view: View) -> None:
        self.direction, self.view = direction, view
        super().__init__(f"touched something {math.degrees(direction):.0f} degrees to the left")


class BumpedInDoor(Bumped):
    """The same among the jambs of a ``passage``, on the way in the direction ``sign`` through it.

    Most likely the robot is not where it believes to be, or does not look where it believes to.
    """

    def __init__(self, bumped: Bumped, passage: Passage, sign: float) -> None:
        self.passage, self.sign = passage, sign
        super().__init__(bumped.direction, bumped.view)
        self.args = (f"{self}, in door {passage.name}",)


class DoorTrouble(Trouble):
    """Trouble with a ``door``."""

    def __init__(self, door: str, text: str) -> None:
        self.door = door
        super().__init__(text)


class DoorShut(DoorTrouble):
    """A door did not open in time."""

    def __init__(self, door: str, seconds: float) -> None:
        self.seconds = seconds
        super().__init__(door, f"door {door} stayed shut for {seconds:.0f} s")


class DoorObstructed(DoorTrouble):
    """Somebody stands in an open door, around ``at``, and does not go away."""

    def __init__(self, door: str, at: Point, seconds: float) -> None:
        self.at, self.seconds = at, seconds
        super().__init__(door, f"somebody stood in door {door} for {seconds:.0f} s")


class DoorMissed(DoorTrouble):
    """The robot could not line itself up with a door."""

    def __init__(self, door: str) -> None:
        super().__init__(door, f"could not get into line with door {door}")


class OffCourse(DoorTrouble):
    """The robot stands elsewhere than it believed: a door that it sees open tells it where.

    ``pose`` is that place on the map; ``metres`` is how far beside it the door was looked for, and
    ``radians`` by how much turned.
    """

    def __init__(self, door: str, pose: Pose, *, metres: float, radians: float) -> None:
        self.pose, self.metres, self.radians = pose, metres, radians
        degrees = round(math.degrees(abs(radians)))
        super().__init__(
            door,
            f"saw door {door} open {abs(metres):.2f} m beside and turned by {degrees} degrees from "
            "where it was looked for",
        )


class WayBlocked(Trouble):
    """Something stands in the way, near ``at``, and does not go away."""

    def __init__(self, at: Point) -> None:
        self.at = at
        super().__init__(f"the way is blocked near ({at[0]:.1f}, {at[1]:.1f})")


class Stuck(Trouble):
    """No progress was made for ``seconds``."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        super().__init__(f"came no nearer for {seconds:.0f} s")


class Disobeyed(Trouble):
    """The wheels stood for ``seconds`` though told to move."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        super().__init__(
            f"the wheels did not turn for {seconds:.0f} s though told to: the battery may be "
            "empty, or a stop be pressed"
        )


class Astray(Trouble):
    """The position estimate fell apart."""

    def __init__(self) -> None:
        super().__init__("the sonars contradict the map where the robot believes to be")
