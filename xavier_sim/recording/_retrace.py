"""Simulates a recording again: the same world and commands must give the same sensors, bit for bit.

The world is a pure function of floor, seed, profile and what is done to it at each tick. All of
that is in a recording, and a snapshot of the world as it stood at the beginning.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tca_bus import TcaError
from xavier_sim.messages import AnyFault, DoorMoved, Fault, Sensors
from xavier_sim.recording._format import Beginning, RecordingFileError
from xavier_sim.recording._reader import RecordingReader
from xavier_sim.recording._ticks import NO_TICK, Tick, ticks_of
from xavier_sim.robot import Reading
from xavier_sim.sensors import Rays
from xavier_sim.world import World

MakeFault = Callable[[World, AnyFault], None]
"""Does a fault to a world."""


class RetraceError(TcaError):
    """A recording comes out otherwise when it is simulated again: ``field`` at ``tick``."""

    def __init__(self, file: Path, tick: int, field: str) -> None:
        self.file, self.tick, self.field = file, tick, field
        super().__init__(f"recording {file} comes out otherwise here: {field} at tick {tick}")


def retrace(reader: RecordingReader, *, make_fault: MakeFault, rays: Rays = "auto") -> int:
    """Simulate a recording again, and compare what is sensed at each tick.

    Args:
        reader: that was entered.
        make_fault: does a recorded fault to the world.
        rays: what casts the rays of the sensors.

    Returns:
        How many ticks came out the same.

    Raises:
        RetraceError: one came out otherwise.
        RecordingFileError: the recording is damaged, has no tick, or is not of one robot alone.
    """
    world = _world(reader.beginning, reader.path, rays)
    count = 0
    for tick in ticks_of(reader, reader.path):
        _compare(world.reading, tick.sensors, reader.path)
        count += 1
        _do(world, tick, make_fault)
    if not count:
        raise RecordingFileError(reader.path, NO_TICK)
    return count


def _world(beginning: Beginning, path: Path, rays: Rays) -> World:
    robots = tuple(beginning.world.get("robots", ()))
    if len(robots) != 1:
        why = f"is of a world with {len(robots)} robots; it has the commands of one"
        raise RecordingFileError(path, why)
    world = World(
        beginning.floor,
        beginning.seed,
        beginning.profile,
        robots=robots,
        people=beginning.people,
        carts=beginning.carts,
        rays=rays,
    )
    try:
        world.restore(beginning.world)
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        why = f"begins with a world that cannot be restored here ({error!r})"
        raise RecordingFileError(path, why) from error
    return world


def _do(world: World, tick: Tick, make_fault: MakeFault) -> None:
    for change in tick.changes:
        match change:
            case DoorMoved(room=room, open=is_open, door=door):
                world.set_door(door or room, is_open=is_open)
            case Fault(fault=fault):
                make_fault(world, fault)
    if tick.command is not None:
        world.step(tick.command.speed, tick.command.turn_rate)


def _compare(now: Reading, then: Sensors, path: Path) -> None:
    for field in Reading._fields:
        here, there = getattr(now, field), getattr(then, field)
        if np.asarray(here).tobytes() != np.asarray(there).tobytes():
            raise RetraceError(path, then.tick, field)
