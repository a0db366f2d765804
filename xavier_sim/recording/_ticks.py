"""A recording tick by tick: what the robot sensed, what it did then, and what it said."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import BaseModel

from tca_bus import Broadcast, InvalidMessageError
from xavier_sim.messages import (
    SONAR_COUNT,
    DoorMoved,
    Drive,
    Fault,
    PlateReading,
    Sensors,
    TrueLocation,
)
from xavier_sim.recording._format import Entry, RecordingFileError
from xavier_sim.recording._wire_names import decode

NO_TICK = "has no whole tick in it"
"""What is wrong with a recording of nothing."""

_SHAPES = {"sonar": (SONAR_COUNT,), "odom": (3,)}
"""What the base itself reads; beams have as many numbers as a robot's profile says."""


@dataclass
class Tick:
    """One control tick of a recording.

    ``command`` is what its wheels were told, None at the last one; ``said`` what it broadcast
    beside its sensors, ``plates`` what its camera read when it was asked, ``changes`` what was
    done to the world, in order.
    """

    sensors: Sensors
    truth: TrueLocation | None = None
    command: Drive | None = None
    said: list[Broadcast] = field(default_factory=list)
    plates: list[PlateReading] = field(default_factory=list)
    changes: list[DoorMoved | Fault] = field(default_factory=list)

    def add(self, message: BaseModel) -> None:
        """Take in what was recorded after the sensors and before those of the next tick."""
        if isinstance(message, DoorMoved | Fault):
            self.changes.append(message)
        match message:
            case TrueLocation():
                self.truth = message
            case Drive():
                self.command = message
            case PlateReading():
                self.plates.append(message)
            case Broadcast():
                self.said.append(message)
            case _:
                # What faults do is in the readings.
                return


def ticks_of(entries: Iterable[Entry], path: Path) -> Iterator[Tick]:
    """The ticks of a recording, in order.

    Args:
        entries: what a reader gives.
        path: of the recording, for errors.

    Raises:
        RecordingFileError: while iterating, a message is not what its channel says.
    """
    tick: Tick | None = None
    for entry in entries:
        message = _message(entry, path)
        if isinstance(message, Sensors):
            if tick is not None:
                yield tick
            tick = Tick(message)
        elif tick is not None and message is not None:
            tick.add(message)
    if tick is not None:
        yield tick


def _message(entry: Entry, path: Path) -> BaseModel | None:
    try:
        message = decode(entry.name, entry.payload)
        if isinstance(message, Sensors):
            _check_shapes(message)
    except InvalidMessageError as error:
        why = f"cannot be played from record {entry.sequence} on: {error}"
        raise RecordingFileError(path, why) from error
    return message


def _check_shapes(sensors: Sensors) -> None:
    wrong = [
        f"{name}: has shape {found}, expected {shape}"
        for name, shape in _SHAPES.items()
        if (found := getattr(sensors, name).shape) != shape
    ]
    if wrong:
        raise InvalidMessageError(sensors.wire_name, wrong)
