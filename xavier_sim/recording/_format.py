"""What a recording is: an MCAP file of the robot's messages as they were on the wire.

Each lies in a channel ``wire/NAME``; beside those are channels that Foxglove shows, made from
them. Every record has the simulated time as its log time and a number of its own, which grows
through the whole file: the order of time and number is the order in which things happened.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict

from tca_bus import Payload, TcaError
from xavier_sim.messages import BatteryState, DoorState, FloorPlan
from xavier_sim.profile import RobotProfile

PROFILE = "xavier"
FORMAT = 1
LIBRARY = f"rogue-on-xavier {version('rogue-on-xavier')}"

BEGINNING = "/beginning"
"""Topic of the first record, a `Beginning`."""

WIRE = "wire/"
"""Before the wire name of a message, or of an answer with ``.reply`` after it: its topic."""

TASKS = "/tasks"
"""Topic of task states, as central publishes them."""

BELIEF = "/belief"
"""Topic of the navigator's belief, with its entropy."""

END = "xavier.end"
"""Name of the metadata that a recorder writes at last."""

PROGRESS = "/progress"
"""Topic of how the drive under way goes."""

SEQUENCES = 1 << 32
"""MCAP numbers messages in 32 bits; a recording has fewer."""


class Beginning(BaseModel):
    """How things stood when the recording began.

    ``speed`` is simulated seconds per wall second, None for lockstep; ``time`` simulated seconds
    since the epoch. ``floor`` is the building as it really is, not the navigator's map; ``people``
    walk its corridors and ``carts`` stand in them. ``world`` is the snapshot of the world, from
    which it goes on bit for bit.
    """

    model_config = ConfigDict(frozen=True)

    format: int = FORMAT
    floor: FloorPlan
    seed: int
    speed: float | None
    time: float
    doors: tuple[DoorState, ...]
    battery: BatteryState
    profile: RobotProfile
    people: int
    carts: int
    world: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Entry:
    """One message of a recording as it was on the wire.

    ``name`` is its wire name; ``time`` nanoseconds of simulated time since the epoch.
    """

    name: str
    payload: Payload
    time: int
    sequence: int


class RecordingFileError(TcaError, ValueError):
    """A recording cannot be written, or not be read; ``why`` is a half-sentence about it."""

    exit_code = 2

    def __init__(self, file: Path, why: str) -> None:
        self.file, self.why = file, why
        super().__init__(f"recording {file} {why}")


def nanoseconds(seconds: float) -> int:
    """Seconds since the epoch as MCAP counts them."""
    return round(seconds * 1e9)
