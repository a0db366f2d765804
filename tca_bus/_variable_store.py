"""The tables of shared variables in central's journal."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import aiosqlite
from pydantic import ValidationError

from tca_bus._journal import JournalError
from tca_bus._variables import MOST_CHANGES, VariableChange, VariableState, VariableTable


async def load_variables(database: aiosqlite.Connection) -> VariableTable:
    """What the journal knows of the variables.

    Raises:
        JournalError: A line cannot be understood.
    """
    kept = await _rows(database, "SELECT name, state, schema FROM variables")
    made = await _rows(database, "SELECT id, change FROM variable_changes ORDER BY number")
    try:
        return VariableTable(
            [VariableState.model_validate_json(state) for _, state, _ in kept],
            {name: json.loads(schema) for name, _, schema in kept if schema is not None},
            [(id, VariableChange.model_validate_json(change)) for id, change in made],
        )
    except (ValidationError, ValueError) as error:
        raise JournalError("variables", f"they cannot be read: {error}") from error


async def save_changes(
    database: aiosqlite.Connection,
    changes: Sequence[tuple[str, VariableChange]],
    schema_of: Callable[[str], dict[str, Any] | None],
) -> None:
    """Write changes; the caller commits them."""
    for id, change in changes:
        state, schema = change.after, schema_of(change.after.name)
        await database.execute(
            "INSERT OR REPLACE INTO variables (name, state, schema) VALUES (?, ?, ?)",
            (state.name, state.model_dump_json(), None if schema is None else json.dumps(schema)),
        )
        await database.execute(
            "INSERT OR REPLACE INTO variable_changes (id, change) VALUES (?, ?)",
            (id, change.model_dump_json()),
        )
    await database.execute(
        "DELETE FROM variable_changes WHERE number <= "
        "(SELECT max(number) FROM variable_changes) - ?",
        (MOST_CHANGES,),
    )


async def _rows(database: aiosqlite.Connection, query: str) -> list[Any]:
    async with database.execute(query) as cursor:
        return list(await cursor.fetchall())
