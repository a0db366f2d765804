"""``xavier run --record``, ``replay`` and ``verify``: a robot into a file, and out of one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus import BusOptions, configure_logging
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options, emit, emit_json, note
from xavier_sim.recording import (
    Beginning,
    RecordedRobot,
    Recorder,
    RecordingReader,
    listening,
    retrace,
)
from xavier_sim.running import RobotModule, RobotState, Team, make_fault, parse_speed, run_team
from xavier_sim.sensors import Rays
from xavier_sim.snapshots import SnapshotFile


async def replay(
    file: Path,
    /,
    *,
    speed: str = "1",
    goals: bool = False,
    patience: Annotated[float, Parameter(validator=Number(gt=0.0))] = 600.0,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Play a recorded robot to the navigator in place of the simulated one, to its end.

    Args:
        file: A recording made by 'xavier run --record'.
        speed: Recorded seconds per second, or "max" for lockstep: each tick waits for the
            navigator's answer to it.
        goals: In lockstep, stand still where the recorded navigator had a goal until this one
            has one too; then it gives the same commands to the wheels.
        patience: With --goals, wall seconds to stand still for a navigator or for its goal; then
            the command ends with code 4.
        flags: Where the bus is.
    """
    configure_logging("xavier", level=flags.level, json=flags.json)
    pace = parse_speed(speed)
    with RecordingReader(file) as reader:
        limit = patience if goals else math.inf
        robot = await RecordedRobot.open(reader, speed=pace, goals=goals, patience=limit)
        note(f"playing {file}" + (", as fast as the navigator answers" if pace is None else ""))
        await RobotModule(robot, None, bus_options(flags)).run()
        _sum_up(robot, reader, flags)


def verify(
    file: Path,
    /,
    *,
    rays: Annotated[Rays, Parameter(env_var="XAVIER_RAYS")] = "numpy",
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Simulate a recording again, and compare each sensor reading bit for bit.

    Args:
        file: A recording made by 'xavier run --record'.
        rays: What casts the rays of the sensors; it must make no difference.
        flags: Shared flags; no bus is needed.
    """
    with RecordingReader(file) as reader:
        ticks = retrace(reader, make_fault=make_fault, rays=rays)
    _say_what_lacks(reader, "compared")
    if flags.json:
        emit_json({"ticks": ticks, "complete": reader.is_finished})
    else:
        what = "1 tick comes" if ticks == 1 else f"{ticks:,} ticks come"
        emit(f"{what} out the same, bit for bit")


async def run_recorded(
    state: RobotState, store: SnapshotFile | None, options: BusOptions, file: Path
) -> None:
    """Run a robot until it is cancelled, and record it.

    Raises:
        RecordingFileError: the file cannot be made, or not be written any more.
    """
    async with Recorder(file, beginning_of(state)) as recorder, listening(recorder, options):
        await RobotModule(state, store, options, recorder).run()


async def run_team_recorded(
    team: Team, store: SnapshotFile | None, options: Mapping[str, BusOptions], file: Path
) -> None:
    """Run several robots until they are cancelled, and record each in a file of its own.

    Raises:
        RecordingFileError: a file cannot be made, or not be written any more.
    """
    recorders = dict[str, Recorder]()
    async with AsyncExitStack() as stack:
        for robot in team.robots:
            path = file.with_stem(f"{file.stem}-{robot.name}")
            recorder = await stack.enter_async_context(Recorder(path, beginning_of(robot)))
            await stack.enter_async_context(listening(recorder, options[robot.name]))
            recorders[robot.name] = recorder
        await run_team(team, store, options, recorders)


def beginning_of(state: RobotState) -> Beginning:
    """How things stand, for a recording that begins now."""
    world = state.world
    return Beginning(
        floor=world.plan,
        seed=world.seed,
        profile=world.profile,
        people=world.people,
        carts=world.carts,
        world=world.snapshot(),
        speed=state.speed,
        time=state.now,
        doors=tuple(state.door_states()),
        battery=state.battery_state(),
    )


def _say_what_lacks(reader: RecordingReader, done: str) -> None:
    if not reader.is_finished:
        note(f"the recording was cut off; all that is whole in it was {done}")
    elif reader.dropped:
        note(f"the recording lacks {reader.dropped:,} messages that its disk was too slow for")


def _sum_up(robot: RecordedRobot, reader: RecordingReader, flags: BusFlags) -> None:
    _say_what_lacks(reader, "played")
    if flags.json:
        emit_json({"ticks": robot.played, "complete": reader.is_finished})
    else:
        emit(f"played {robot.played:,} ticks, to tick {robot.tick:,}")
