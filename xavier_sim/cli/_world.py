"""Commands of ``xavier`` that look at the running world, or change it."""

from __future__ import annotations

from typing import Literal

from tca_bus import RefusedError, TcaError
from tca_bus.cli import (
    DEFAULT_FLAGS,
    BusFlags,
    emit,
    emit_json,
    show_table,
)
from xavier_sim.cli._client import client
from xavier_sim.messages import (
    BatteryState,
    DoorState,
    MoveDoor,
    MovePerson,
    ReadBattery,
    ReadPlate,
    TrueLocation,
    WhereReally,
    WorldDoors,
)


async def door(
    room: str, move: Literal["open", "close"], /, *, flags: BusFlags = DEFAULT_FLAGS
) -> None:
    """Open or close the door of a room.

    Args:
        room: A room such as r-5303, the first of whose doors is meant, or a door by its name.
        move: What to do with it.
        flags: Where the bus is.
    """
    async with client(flags) as module:
        states = await module.query(WorldDoors())
        names = {name for one in states for name in (one.room, one.door) if name}
        if room.lower() not in names:
            raise _no_such_door(room, sorted(names))
        state = await module.query(MoveDoor(room=room.lower(), open=move == "open"))
    if state.open != (move == "open"):
        raise RefusedError(
            f"closing the door of {state.room}", "somebody or something stands in it"
        )
    if flags.json:
        emit_json(state)
    else:
        emit(f"The door of {state.room} is {_stands(state)}.")


async def doors(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show how every door stands."""
    async with client(flags) as module:
        states = await module.query(WorldDoors())
    if flags.json:
        emit_json(states)
    else:
        rows = [(state.room, state.door or "-", _stands(state)) for state in states]
        show_table(["room", "door", "stands"], rows)


async def where(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show where the robot really is; 'navigate where' shows where it believes to be."""
    async with client(flags) as module:
        truth = await module.query(WhereReally())
    if flags.json:
        emit_json(truth)
    else:
        show_table(["what", "value"], _location_rows(truth))


async def battery(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show how full the battery is."""
    async with client(flags) as module:
        state = await module.query(ReadBattery())
    if flags.json:
        emit_json(state)
    else:
        show_table(["what", "value"], _battery_rows(state))


async def plate(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Let the camera read the door plate that it sees best."""
    async with client(flags) as module:
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
    async with client(flags) as module:
        rooms = [state.room for state in await module.query(WorldDoors())]
        if room.lower() not in rooms:
            raise _no_such_door(room, rooms)
        state = await module.query(MovePerson(room=room.lower(), present=where_to == "in"))
    if flags.json:
        emit_json(state)
    else:
        emit(f"Whoever works in {state.room} is {'in' if state.present else 'out'}.")


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
