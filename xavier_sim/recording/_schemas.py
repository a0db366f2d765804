"""JSON schemas as Foxglove reads them.

Its reader knows plain types, objects with properties, and arrays of those; it refuses a whole
channel for a field of any other kind. So such fields, and those that may be null, are left out:
they are in the messages all the same, and a viewer shows them.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import BaseModel

Schema = dict[str, Any]

PLAIN = frozenset({"boolean", "integer", "number", "string"})


@cache
def viewer_schema(kind: type[BaseModel], title: str) -> Schema:
    """The schema of a model, with a title, as far as every viewer can follow it."""
    whole = kind.model_json_schema(mode="serialization")
    known = whole.get("$defs", {})
    return {**(_simple(whole, known) or _object({}, [])), "title": title}


def _simple(schema: Schema, known: dict[str, Schema]) -> Schema | None:
    """What a viewer can follow of a schema; None if nothing."""
    if "$ref" in schema:
        return _simple(known[schema["$ref"].rsplit("/", 1)[-1]], known)
    match schema.get("type"):
        case "object" if "properties" in schema:
            found = {name: _simple(item, known) for name, item in schema["properties"].items()}
            kept = {name: item for name, item in found.items() if item is not None}
            return _object(kept, schema.get("required", []))
        case "array" if "items" in schema:
            item = _simple(schema["items"], known)
            is_nested = item is None or item["type"] == "array"
            return None if is_nested else {"type": "array", "items": item}
        case str() as word if word in PLAIN:
            return {"type": word}
        case _:
            return None


def _object(properties: dict[str, Schema], required: list[str]) -> Schema:
    needed = [name for name in required if name in properties]
    return {"type": "object", "properties": properties, "required": needed}
