"""``xavier fault``: what is wrong with the robot, and what shall be."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Literal

from cyclopts import App
from pydantic import ValidationError

from tca_bus import ConfigError, HandlerFailedError, Query, TcaError
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json, show_table
from xavier_sim.cli._client import client
from xavier_sim.messages import (
    AnyFault,
    CameraPower,
    Fault,
    FaultState,
    Kidnap,
    LaserOffset,
    Mend,
    MoveItem,
    ReadFaults,
    Slip,
    SonarFault,
    WheelSlip,
)


class NoSuchRoomError(TcaError, LookupError):
    """The floor has no such room; says what the robot said, with the names that are near."""

    exit_code = 2


FLAGS = {"theta": "heading"}
"""Fields of faults that have another name on the command line."""

fault = App(
    name="fault",
    help="Let something go wrong with the robot at once, show what is wrong, or mend it.",
    help_format="markdown",
)


@fault.command(name="list")
async def list_faults(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show what is wrong with the robot."""
    await _tell(ReadFaults(), flags)


@fault.command
async def clear(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Mend all that was broken: camera, sonars, lasers, wheels, and what is still to slip.

    A robot that was put down elsewhere stays there, and its odometry stays as wrong as it is.
    """
    await _make(Mend, flags)


@fault.command
async def kidnap(
    room: str | None = None,
    /,
    *,
    x: float | None = None,
    y: float | None = None,
    ahead: float = 0.0,
    left: float = 0.0,
    heading: float | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Put the robot down elsewhere without telling the navigator.

    Args:
        room: The room at whose place to put it down,
        x: or where in metres east
        y: and north,
        ahead: or how many metres ahead of where it is,
        left: and to its left.
        heading: Where it looks then, radians counter-clockwise from east; as before if not given.
        flags: Where the bus is.
    """
    there = room.lower() if room else None
    await _make(lambda: Kidnap(room=there, x=x, y=y, ahead=ahead, left=left, theta=heading), flags)


@fault.command
async def odometry(metres: float, /, *, turn: float = 0.0, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Let the odometry count too much, or too little, for a while.

    On a corridor of like doors, one door's distance too little makes the robot stop one door too
    far: doors 5301 to 5315 are 3.597 m apart.

    Args:
        metres: What it counts too much over the way that follows, up to 50; too little when
            negative.
        turn: Radians that its heading jumps at once, counter-clockwise, -3.2 to 3.2.
        flags: Where the bus is.
    """
    await _make(lambda: Slip(metres=metres, turn=turn), flags)


@fault.command
async def wheels(
    share: float = 0.0, /, *, veer: float = 0.0, flags: BusFlags = DEFAULT_FLAGS
) -> None:
    """Let a wheel slip until it is mended: the robot moves less than its odometry counts.

    Args:
        share: Share of what the wheels turn that moves the robot nowhere, 0 to 0.8; they grip
            again when it is 0, or not given.
        veer: Radians by which the robot turns, unnoticed, for each metre that the wheels turn,
            -0.5 to 0.5.
        flags: Where the bus is.
    """
    await _make(lambda: WheelSlip(share=share, veer=veer), flags)


@fault.command
async def camera(power: Literal["on", "off"], /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Take the camera away, or bring it back.

    Args:
        power: What to do with it.
        flags: Where the bus is.
    """
    await _make(lambda: CameraPower(on=power == "on"), flags)


@fault.command
async def sonar(
    number: int,
    state: Literal["dead", "stuck", "sound"],
    /,
    *,
    metres: float | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Let a sonar hear nothing, or always read the same, or make it sound again.

    Args:
        number: Of the sonar, 0 to 23: it looks so many times 15 degrees to the left.
        state: What becomes of it.
        metres: What a stuck one reads; what it read last when not given.
        flags: Where the bus is.
    """
    await _make(lambda: SonarFault(number=number, state=state, metres=metres), flags)


@fault.command
async def laser(*, metres: float = 0.0, turn: float = 0.0, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Knock striper and lidar, so that they measure wrongly; with neither flag they are sound.

    Args:
        metres: How much too far they measure, -1 to 1.
        turn: Radians to the left of where they should look, -0.5 to 0.5.
        flags: Where the bus is.
    """
    await _make(lambda: LaserOffset(metres=metres, turn=turn), flags)


@fault.command
async def item_taken(user: str, item: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Let a user take an item from the tray in passing.

    Args:
        user: Whose it is.
        item: Such as delivermail.
        flags: Where the bus is.
    """
    await _move_item(MoveItem(user=user, item=item, action="taken"), flags)


@fault.command
async def item_brought(user: str, item: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Let somebody else, a person or a robot, bring an item to its user.

    Args:
        user: Whose it is.
        item: Such as delivermail.
        flags: Where the bus is.
    """
    await _move_item(MoveItem(user=user, item=item, action="brought"), flags)


async def _make(make: Callable[[], AnyFault], flags: BusFlags) -> None:
    """Make a fault and tell what is wrong then.

    Raises:
        ConfigError: there can be no such fault.
    """
    try:
        made = make()
    except ValidationError as error:
        raise _explained(error) from error
    await _tell(Fault(fault=made), flags)


def _explained(error: ValidationError) -> ConfigError:
    """The first thing wrong: the field, what it is, and what it should be."""
    first = error.errors(include_url=False)[0]
    expected = re.sub("^(Input should be|Value error, expected) ", "", first["msg"])
    if first["loc"]:
        name = str(first["loc"][0])
        return ConfigError(FLAGS.get(name, name), first["input"], expected)
    given = (f"{name} {value}" for name, value in first["input"].items() if value is not None)
    return ConfigError("the fault", ", ".join(given), expected)


async def _tell(message: Query[FaultState], flags: BusFlags) -> None:
    async with client(flags) as module:
        try:
            state = await module.query(message)
        except HandlerFailedError as error:
            if error.failure.name != "unknown_room":
                raise
            raise NoSuchRoomError(error.failure.text) from error
    if flags.json:
        emit_json(state)
    else:
        show_table(["what", "value"], _rows(state))


async def _move_item(message: MoveItem, flags: BusFlags) -> None:
    async with client(flags) as module:
        moved = await module.query(message)
    if flags.json:
        emit_json(moved)
    else:
        emit(f"{moved.item} of {moved.user} was {moved.action}.")


def _rows(state: FaultState) -> list[tuple[str, str]]:
    return [
        ("room", state.room or "none"),
        ("space", state.space or "none"),
        ("camera", "on" if state.camera_on else "off"),
        ("odometry", f"{state.slip:.3f} m to count wrongly"),
        ("wheels", f"{state.wheels.share:.0%} slip, {state.wheels.veer:.3f} rad astray a metre"),
        ("sonars", ", ".join(f"{one.number} {one.state}" for one in state.sonars) or "sound"),
        ("laser", f"{state.laser.metres:.3f} m too far, {state.laser.turn:.3f} rad askew"),
        ("tick", str(state.tick)),
    ]
