"""A robot from a recording, which stands for a world: it goes on tick by tick as it did then."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Protocol

from tca_bus import Broadcast, Module
from xavier_sim.messages import (
    Battery,
    BatteryState,
    DoorMoved,
    DoorState,
    PlateReading,
    Sensors,
    Standing,
    TrueLocation,
)
from xavier_sim.recording._format import RecordingFileError
from xavier_sim.recording._reader import RecordingReader
from xavier_sim.recording._recorded_desk import RecordedDesk
from xavier_sim.recording._ticks import NO_TICK, Tick, ticks_of
from xavier_sim.robot import Reading

READ_AHEAD = 64
"""Ticks that are read from the file at a time."""


class Outlet(Protocol):
    """Tells all on the bus."""

    async def broadcast(self, message: Broadcast) -> None:
        """Tell all who listen."""


class Reflex(Protocol):
    """Is told of every reading."""

    def sense(self, reading: Reading) -> None:
        """Take in the reading of a tick."""


class Ahead:
    """The ticks that come, read from the file some at a time, on a thread."""

    def __init__(self, ticks: Iterator[Tick]) -> None:
        self._ticks = ticks
        self._read: deque[Tick] = deque()
        self._trouble: RecordingFileError | None = None

    @property
    def is_empty(self) -> bool:
        """Whether the recording is at its end."""
        return not self._read and self._trouble is None

    def take(self) -> Tick:
        """The next tick.

        Raises:
            RecordingFileError: the recording is damaged here.
        """
        if not self._read and self._trouble is not None:
            raise self._trouble
        return self._read.popleft()

    async def fill(self) -> None:
        """Read on when nothing is at hand."""
        if not self._read and self._trouble is None:
            await asyncio.to_thread(self._read_some)

    def _read_some(self) -> None:
        try:
            for tick in islice(self._ticks, READ_AHEAD):
                self._read.append(tick)
        except RecordingFileError as error:
            # What comes before it is played first.
            self._trouble = error


class RecordedRobot:
    """Plays a recording in place of a world; commands change nothing.

    Its sensors are those of the recording to the bit, but for ``lockstep``, which says whether
    this one waits. In lockstep it goes on when the driver has answered a tick, whether it has a
    goal or not; with ``goals`` it stands still where the recorded driver had a goal until this
    one has one too, so that a driver that is told the same answers the same.

    Args:
        reader: that was entered, and is left open while this plays.
        ahead: its ticks.
        speed: simulated seconds per wall second, None for lockstep.
        goals: whether to wait for goals.
        patience: wall seconds to wait for one, or for a driver, at most.
    """

    def __init__(
        self,
        reader: RecordingReader,
        ahead: Ahead,
        *,
        speed: float | None,
        goals: bool,
        patience: float = math.inf,
    ) -> None:
        self.speed, self.played, self.tick_limit = speed, 1, 0
        self.patience = patience
        self._reader, self._ahead, self._goals = reader, ahead, goals
        self._now = ahead.take()
        self._looks = 0
        self._doors = {_key(door): door for door in reader.beginning.doors}
        self._battery = reader.beginning.battery
        self._outlet: Outlet | None = None
        self._reflex: Reflex | None = None

    @classmethod
    async def open(
        cls,
        reader: RecordingReader,
        *,
        speed: float | None,
        goals: bool = False,
        patience: float = math.inf,
    ) -> RecordedRobot:
        """Begin with the first tick of a recording.

        Raises:
            RecordingFileError: there is none in it, or it is damaged.
        """
        ahead = Ahead(ticks_of(reader, reader.path))
        await ahead.fill()
        if ahead.is_empty:
            raise RecordingFileError(reader.path, NO_TICK)
        return cls(reader, ahead, speed=speed, goals=goals, patience=patience)

    @property
    def tick(self) -> int:
        """The control tick that it is at, as it was counted then."""
        return self._now.sensors.tick

    @property
    def now(self) -> float:
        """Simulated seconds since the epoch, as they were then."""
        return self._now.sensors.time

    @property
    def reading(self) -> Reading:
        """What it sensed at this tick."""
        sensors = self._now.sensors
        return Reading(**{name: getattr(sensors, name) for name in Reading._fields})

    @property
    def must_save(self) -> bool:
        """Nothing of it is kept."""
        return False

    @property
    def is_over(self) -> bool:
        """Whether this is the last whole tick of the recording."""
        return self._ahead.is_empty

    def saved(self, *, stopped: bool = False) -> None:
        """Nothing of it is kept."""
        del stopped

    def attach(self, reflex: Reflex) -> None:
        """Let the base's reflex sense this reading and all that come."""
        reflex.sense(self.reading)
        self._reflex = reflex

    async def advance(self, speed: float, turn_rate: float) -> Reading:
        """Say what it said at this tick, and go on to the next; the command is not obeyed.

        Raises:
            RecordingFileError: the recording is damaged from here on.
        """
        del speed, turn_rate
        await self._say()
        self._now = self._ahead.take()
        self._looks = 0
        self.played += 1
        await self._ahead.fill()
        if self._reflex is not None:
            self._reflex.sense(self.reading)
        return self.reading

    def may_tick(
        self, *, driven: bool, answered: bool, busy: bool, moving: bool, holding: bool
    ) -> bool:
        """Whether it goes on in lockstep: when the driver has answered."""
        del moving
        return answered and not holding and self.awaited(driven=driven, busy=busy) is None

    def awaited(self, *, driven: bool, busy: bool) -> str | None:
        """What it stands still for in lockstep, beside the answer of a driver that is there."""
        if not driven:
            return "a module that drives"
        command = self._now.command
        if self._goals and command is not None and command.busy and not busy:
            return "a goal of its driver, as the recorded one had here"
        return None

    def sensors(self) -> Sensors:
        """What it sensed at this tick, as it was then."""
        return self._now.sensors.model_copy(update={"lockstep": self.speed is None})

    def true_location(self) -> TrueLocation:
        """Where it really was at this tick."""
        truth = self._now.truth
        if truth is None:
            raise RecordingFileError(self._reader.path, f"does not tell the truth of {self.tick}")
        return truth

    def standing(self) -> list[Standing]:
        """Nothing: who stood about then is in its readings, and for the eye in the file."""
        return []

    def door_states(self) -> list[DoorState]:
        """How the doors stood at this tick."""
        return list(self._doors.values())

    def battery_state(self) -> BatteryState:
        """How full its battery was when it last said so."""
        return self._battery

    def plate(self) -> PlateReading | None:
        """What the camera read at this tick: one reading after the other, the last again."""
        plates = self._now.plates
        self._looks += 1
        return plates[min(self._looks, len(plates)) - 1] if plates else None

    def wake_by(self, wake: Callable[[], None]) -> None:
        """Nothing but its driver moves it."""
        del wake

    def open_desk(
        self, module: Module, outlet: Outlet, changed: Callable[[], None]
    ) -> RecordedDesk:
        """Serve what can be asked of a recording."""
        del changed
        self._outlet = outlet
        return RecordedDesk(self, module)

    async def _say(self) -> None:
        for message in self._now.said:
            if isinstance(message, DoorMoved):
                moved = DoorState(room=message.room, open=message.open, door=message.door)
                self._doors[_key(message)] = moved
            elif isinstance(message, Battery):
                self._battery = message.state
            if self._outlet is not None:
                await self._outlet.broadcast(message)


def _key(door: DoorState | DoorMoved) -> str:
    """What tells a door from others; older recordings have only its room."""
    return door.door or door.room
