"""``tca modules`` and ``tca messages``: who is on the bus and what they understand."""

from __future__ import annotations

import json
from typing import Any

from tca_bus import NoHandlerError
from tca_bus._readiness import missing
from tca_bus.cli._client import Seen, joined, look_around
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, note, show_table

ALWAYS_SHOWN = ("name", "pid", "host", "state", "provides")
"""Columns of the table that are there even when they are empty."""


async def modules(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """List the modules on the bus: name, process, host, state, and what they handle.

    The state is ready; held or waiting before a module is ready; hung when the process is there
    but does not answer. Resources are what it offers to others, missing what it requires and
    nobody offers.
    """
    async with joined(flags) as module:
        seen = await look_around(module)
        offered = module.available()
    rows = [_row(one, offered) for one in seen]
    if flags.json:
        emit_json(rows)
    elif not rows:
        note(f"no module is on realm {flags.realm!r}")
    else:
        columns = [key for key in rows[0] if key in ALWAYS_SHOWN or any(row[key] for row in rows)]
        show_table(columns, [[_cell(row[key]) for key in columns] for row in rows])


def _row(one: Seen, offered: list[str]) -> dict[str, Any]:
    return {
        "name": one.module.name,
        "pid": one.module.pid,
        "host": one.module.host,
        "state": one.state,
        "provides": list(one.module.provides),
        "resources": list(one.module.resources),
        "requires": list(one.module.requires),
        "missing": missing(one.module.requires, offered),
    }


def _cell(value: Any) -> object:
    return ", ".join(value) if isinstance(value, list) else value


async def messages(name: str | None = None, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """List the messages that modules handle, or show the JSON schemas of one.

    Parameters
    ----------
    name
        Wire name of one message, for its schema.
    """
    known = await _known_messages(name, flags)
    if flags.json:
        emit_json(known[0] if name is not None else known)
    elif name is not None:
        _show_message(known[0])
    else:
        columns = ("name", "class", "modules", "about")
        rows = [
            (m["name"], m["message_class"], ", ".join(m["modules"]), m["summary"]) for m in known
        ]
        show_table(columns, rows)


async def _known_messages(name: str | None, flags: BusFlags) -> list[dict[str, Any]]:

    async with joined(flags) as module:
        seen = await look_around(module)
    found: dict[str, dict[str, Any]] = {}
    for one in seen:
        for message in one.card.provides if one.card else ():
            facts = found.setdefault(message.name, {**message.model_dump(), "modules": []})
            facts["modules"].append(one.module.name)
    if name is not None and name not in found:
        raise NoHandlerError(name, found)
    return [found[key] for key in sorted(found) if name in {None, key}]


def _show_message(message: dict[str, Any]) -> None:
    modules = ", ".join(message["modules"])
    older = ", ".join(map(str, message["accepts"]))
    accepts = f", accepts {older} too" if older else ""
    emit(f"{message['name']}: {message['message_class']}, revision {message['revision']}{accepts}")
    most = f"{message['capacity']} at once" if message["capacity"] else "as many as come"
    emit(f"{message['summary']}\nhandled by {modules}, {most}")
    emit("message " + json.dumps(message["message_schema"], indent=2))
    emit("answer " + json.dumps(message["reply_schema"], indent=2))
