"""All that the navigator sees, believes and wants at one moment, for those who draw it."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from navigate.messages.drives import DriveProgress
from navigate.messages.position import BeliefState
from tca_bus import Query


class Outlook(BaseModel):
    """What the navigator sees, believes and wants at one moment.

    ``sonar`` is the latest reading of each sonar in metres from the ring, None for no echo, and
    empty before there are any; ``seen`` are the points that lasers see, metres ahead of the robot
    and to its left. ``bump`` has a bit for each panel that is pressed. ``drive`` is the drive under
    way, ``way`` the points that it has yet to pass, in metres. ``shut`` are doors believed to be
    shut, ``blocked`` points where something stood in the way lately. ``faults`` are the senses
    that are not believed, such as ``sonar 3``, with the reason: ``dead``, ``stuck`` or ``off``.
    """

    model_config = ConfigDict(frozen=True)

    belief: BeliefState
    sonar: list[float | None]
    seen: list[tuple[float, float]] = []
    bump: int
    drive: DriveProgress | None
    way: list[tuple[float, float]]
    shut: list[str]
    blocked: list[tuple[float, float]]
    faults: dict[str, str] = {}


class ShowOutlook(Query[Outlook]):
    """Ask for all of it at once."""

    wire_name = "navigateOutlook"
