"""``tca var``: the shared variables of the realm."""

from __future__ import annotations

import json as jsonlib
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Annotated, Any

from cyclopts import Parameter

from tca_bus import Module, NoHandlerError, Reading, Variable
from tca_bus.cli._app import make_app
from tca_bus.cli._client import NoCentralError, joined
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, note, show_table
from tca_bus.cli._payload import JsonText, parse_value

var = make_app("var", help="Read, set and follow the variables that all modules share.")


@asynccontextmanager
async def _on_central(flags: BusFlags) -> AsyncIterator[Module]:
    async with joined(flags) as module:
        try:
            yield module
        except NoHandlerError as error:
            if not error.message.startswith("central:"):
                raise
            raise NoCentralError(module.options.realm) from error


@var.command(name="list")
async def list_(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """List the variables that were ever set: value, sequence number, who set it and when."""
    async with _on_central(flags) as module:
        states = await module.variables()
    if flags.json:
        emit_json(states)
    elif not states:
        note(f"no variable was ever set on realm {flags.realm!r}")
    else:
        now = time.time()
        rows = [
            (s.name, jsonlib.dumps(s.value), s.sequence, s.writer, f"{now - s.changed:.1f} s ago")
            for s in states
        ]
        show_table(("name", "value", "sequence", "writer", "changed"), rows)


@var.command
async def get(name: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Print the value of a variable as JSON; with --json its sequence number and writer too.

    Parameters
    ----------
    name
        Name of the variable; 'tca var list' shows them.
    """
    variable = Variable[Any](name, Any)
    async with _on_central(flags) as module:
        reading = await module.read(variable)
    _show(name, reading, flags)


@var.command(name="set")
async def set_(
    name: str,
    json: JsonText,
    /,
    *,
    expected: int | None = None,
    redefine: Annotated[bool, Parameter(negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Set a variable and print its new sequence number.

    Parameters
    ----------
    name
        Name of the variable.
    json
        Its value as JSON; - reads it from standard input.
    expected
        Set it only if it is at this sequence number, 0 for never set.
    redefine
        Set it though the value is of another type than the one that modules declared.
    """
    variable, value = Variable[Any](name, Any), parse_value(name, json)
    async with _on_central(flags) as module:
        sequence = await module.set(variable, value, expected=expected, redefine=redefine)
    if flags.json:
        emit_json({"name": name, "sequence": sequence})
    else:
        emit(str(sequence))


@var.command
async def swap(
    name: str,
    json: JsonText,
    /,
    *,
    expected: int | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Set a variable and print the value that it had, null if it had none.

    Parameters
    ----------
    name
        Name of the variable.
    json
        Its new value as JSON; - reads it from standard input.
    expected
        Set it only if it is at this sequence number, 0 for never set.
    """
    variable, value = Variable[Any](name, Any), parse_value(name, json)
    async with _on_central(flags) as module:
        emit_json(await module.swap(variable, value, expected=expected), line=True)


@var.command
async def watch(name: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Print the value of a variable, and again with each change, until interrupted.

    Parameters
    ----------
    name
        Name of the variable; it may be one that was not set yet.
    """
    variable = Variable[Any](name, Any)
    async with joined(flags) as module, module.watch(variable) as changes:
        async for reading in changes:
            _show(name, reading, flags, line=True)


def _show(name: str, reading: Reading[Any], flags: BusFlags, *, line: bool = False) -> None:
    if not flags.json:
        emit_json(reading.value, line=True)
        return
    facts = {"name": name, "value": reading.value, "sequence": reading.sequence}
    emit_json({**facts, "writer": reading.writer, "changed": reading.changed}, line=line)
