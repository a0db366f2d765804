"""Commands of ``xavier`` that look at the running world, or change it."""

from __future__ import annotations

import os
from typing import Literal

from cyclopts import App
from pydantic import ValidationError

from tca_bus import ConfigError, Module, Query, RefusedError, TcaError
from tca_bus.cli import (
    DEFAULT_FLAGS,
    BusFlags,
    bus_options,
    emit,
    emit_json,
    show_table,
)
from xavier_sim.messages import (
    BatteryState,
    CameraPower,
    DoorState,
    Fault,
    FaultState,
    Kidnap,
    LaserOffset,
    MoveDoor,
    MoveItem,
    MovePerson,
    ReadBattery,
    ReadPlate,
    Slip,
    SonarFault,
    TrueLocation,
    WhereReally,
    WorldDoors,
)


async def door(
    room: str, move: Literal["open", "close"], /, *, flags: BusFlags = DEFAULT_FLAGS
) -> None:
    """Open or close the door of a room.

    Args:
        room: A room such as r-5303, or a door by its name.
        move: What to do with it.
        flags: Where the bus is.
    """
    async with _client(flags) as module:
        rooms = [state.room for state in await module.query(WorldDoors())]
        if room.lower() not in rooms and not room.startswith("d-"):
            raise _no_such_door(room, rooms)
        state = await module.query(MoveDoor(room=room.lower(), open=move == "open"))
    if state.open != (move == "open"):
        raise RefusedError(f"closing the door of {state.room}", "the robot stands in it")
    if flags.json:
        emit_json(state)
    else:
        emit(f"The door of {state.room} is {_stands(state)}.")


async def doors(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show how every door stands."""
    async with _client(flags) as module:
        states = await module.query(WorldDoors())
    if flags.json:
        emit_json(states)
    else:
        show_table(["room", "door"], [(state.room, _stands(state)) for state in states])


async def where(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show where the robot really is; 'navigate where' shows where it believes to be."""
    async with _client(flags) as module:
        truth = await module.query(WhereReally())
    if flags.json:
        emit_json(truth)
    else:
        show_table(["what", "value"], _location_rows(truth))


async def battery(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show how full the battery is."""
    async with _client(flags) as module:
        state = await module.query(ReadBattery())
    if flags.json:
        emit_json(state)
    else:
        show_table(["what", "value"], _battery_rows(state))


async def plate(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Let the camera read the door plate that it sees best."""
    async with _client(flags) as module:
        reading = await module.query(ReadPlate())
    if flags.json:
        emit_json(reading)
    elif reading.text is None:
        emit("The camera finds no plate.")
    else:
        emit(f"The plate says {reading.text}, with confidence {reading.confidence:.3f}.")


async def person(
    room: str, where_to: Literal["in", "out"], /, *, flags: BusFlags = DEFAULT_FLAGS
) -> None:
    """Send the one who works in a room out, so that nobody answers there, or back in.

    Args:
        room: A room such as r-5303.
        where_to: Where to.
        flags: Where the bus is.
    """
    async with _client(flags) as module:
        rooms = [state.room for state in await module.query(WorldDoors())]
        if room.lower() not in rooms:
            raise _no_such_door(room, rooms)
        state = await module.query(MovePerson(room=room.lower(), present=where_to == "in"))
    if flags.json:
        emit_json(state)
    else:
        emit(f"Whoever works in {state.room} is {'in' if state.present else 'out'}.")


fault = App(
    name="fault",
    help_format="plaintext",
)


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
    try:
        fault = Kidnap(room=there, x=x, y=y, ahead=ahead, left=left, theta=heading)
    except ValidationError as error:
        given = f"{room or 'no room'}, x {x}, y {y}, ahead {ahead:g}, left {left:g}"
        expected = "a room, or --x and --y, or --ahead and --left, in metres"
        raise ConfigError("where to put the robot", given, expected) from error
    await _make(Fault(fault=fault), flags)


@fault.command
async def odometry(metres: float, /, *, turn: float = 0.0, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Let the wheels slip: the odometry counts too much, or too little.

    On a corridor of like doors, one door's distance too little makes the robot stop one door too
    far: doors 5301 to 5315 are 3.597 m apart.

    Args:
        metres: What it counts too much over the way that follows; too little when negative.
        turn: Radians that its heading jumps at once, counter-clockwise.
        flags: Where the bus is.
    """
    await _make(Fault(fault=Slip(metres=metres, turn=turn)), flags)


@fault.command
async def camera(power: Literal["on", "off"], /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Take the camera away, or bring it back.

    Args:
        power: What to do with it.
        flags: Where the bus is.
    """
    await _make(Fault(fault=CameraPower(on=power == "on")), flags)


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
    try:
        fault = SonarFault(number=number, state=state, metres=metres)
    except ValidationError as error:
        given = f"number {number}, {state}" + ("" if metres is None else f", --metres {metres:g}")
        expected = "a number from 0 to 23, and --metres from 0 to 6.5 for a stuck one only"
        raise ConfigError("the sonar", given, expected) from error
    await _make(Fault(fault=fault), flags)


@fault.command
async def laser(*, metres: float = 0.0, turn: float = 0.0, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Knock striper and lidar, so that they measure wrongly; with neither flag they are sound.

    Args:
        metres: How much too far they measure, -1 to 1.
        turn: Radians to the left of where they should look, -0.5 to 0.5.
        flags: Where the bus is.
    """
    try:
        fault = LaserOffset(metres=metres, turn=turn)
    except ValidationError as error:
        given = f"--metres {metres:g} --turn {turn:g}"
        expected = "--metres from -1 to 1 and --turn from -0.5 to 0.5"
        raise ConfigError("the laser's offset", given, expected) from error
    await _make(Fault(fault=fault), flags)


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


async def _make(message: Query[FaultState], flags: BusFlags) -> None:
    async with _client(flags) as module:
        state = await module.query(message)
    if flags.json:
        emit_json(state)
    else:
        show_table(["what", "value"], _fault_rows(state))


async def _move_item(message: MoveItem, flags: BusFlags) -> None:
    async with _client(flags) as module:
        moved = await module.query(message)
    if flags.json:
        emit_json(moved)
    else:
        emit(f"{moved.item} of {moved.user} was {moved.action}.")


def _client(flags: BusFlags) -> Module:
    return Module(f"xavier-{os.getpid()}", options=bus_options(flags))


def _no_such_door(room: str, rooms: list[str]) -> TcaError:
    from xavier_sim.floors import UnknownDoorError  # noqa: PLC0415 - no other answer needs numpy

    return UnknownDoorError(room, rooms)


def _stands(state: DoorState) -> str:
    return "open" if state.open else "closed"


def _location_rows(truth: TrueLocation) -> list[tuple[str, str]]:
    return [
        ("room", truth.room or "none"),
        ("space", truth.space or "none"),
        ("x", f"{truth.x:.3f} m"),
        ("y", f"{truth.y:.3f} m"),
        ("theta", f"{truth.theta:.3f} rad"),
        ("driven", f"{truth.metres:.1f} m"),
        ("bumps", str(truth.bumps)),
        ("people touched", f"{truth.people_touched}, {truth.people_hit} of them hit"),
    ]


def _battery_rows(state: BatteryState) -> list[tuple[str, str]]:
    at = state.charger
    return [
        ("charge", f"{state.charge:.1%}" + (", low" if state.low else "")),
        ("charging", "yes" if state.charging else "no"),
        ("charger", f"({at.x:.2f}, {at.y:.2f}) m" if at else "none"),
    ]


def _fault_rows(state: FaultState) -> list[tuple[str, str]]:
    return [
        ("room", state.room or "none"),
        ("space", state.space or "none"),
        ("camera", "on" if state.camera_on else "off"),
        ("odometry", f"{state.slip:.3f} m to count wrongly"),
        ("sonars", ", ".join(f"{one.number} {one.state}" for one in state.sonars) or "sound"),
        ("laser", f"{state.laser.metres:.3f} m too far, {state.laser.turn:.3f} rad askew"),
        ("tick", str(state.tick)),
    ]
