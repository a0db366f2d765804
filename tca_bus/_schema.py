"""Checking a value against a JSON schema, as far as message schemas go.

For messages that nobody answers at once, so that a wrong field is told before it is sent. What
this does not know it lets pass: the receiver has the last word.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tca_bus._errors import did_you_mean

Schema = dict[str, Any]

_TYPES: dict[str, type | tuple[type, ...]] = {
    "object": dict,
    "array": list,
    "string": str,
    "boolean": bool,
    "null": type(None),
    "number": (int, float),
    "integer": int,
}


def schema_problems(value: Any, schema: Schema) -> list[str]:
    """What is wrong with a value: one sentence for each problem, with the field's name."""
    return list(_problems(value, schema, schema, ""))


def _problems(value: Any, schema: Schema, root: Schema, where: str) -> Iterator[str]:
    schema = _resolve(schema, root)
    if "anyOf" in schema:
        yield from _any_problems(value, schema["anyOf"], root, where)
        return
    if "type" in schema and not _has_type(value, schema["type"]):
        yield f"{where or 'message'}: expected {schema['type']}, got {_shown(value)}"
        return
    choices = schema.get("enum", [schema["const"]] if "const" in schema else None)
    if choices is not None and value not in choices:
        yield f"{where}: expected one of {choices}, got {_shown(value)}.{_near(value, choices)}"
    if isinstance(value, dict):
        yield from _object_problems(value, schema, root, where)
    if isinstance(value, list) and "items" in schema:
        for number, item in enumerate(value):
            yield from _problems(item, schema["items"], root, f"{where}[{number}]")


def _object_problems(value: Schema, schema: Schema, root: Schema, where: str) -> Iterator[str]:
    fields = schema.get("properties", {})
    prefix = f"{where}." if where else ""
    for name in schema.get("required", []):
        if name not in value:
            yield f"{prefix}{name}: field required"
    for name, item in value.items():
        if name in fields:
            yield from _problems(item, fields[name], root, prefix + name)
        elif schema.get("additionalProperties") is False:
            known = ", ".join(fields) or "no field at all"
            yield f"{prefix}{name}: no such field, expected {known}.{did_you_mean(name, fields)}"


def _any_problems(value: Any, schemas: list[Schema], root: Schema, where: str) -> Iterator[str]:
    tried = [list(_problems(value, schema, root, where)) for schema in schemas]
    if all(tried):
        yield from min(tried, key=len)


def _resolve(schema: Schema, root: Schema) -> Schema:
    reference = schema.get("$ref", "")
    if not reference.startswith("#/$defs/"):
        return schema
    found: Schema = root.get("$defs", {}).get(reference.removeprefix("#/$defs/"), {})
    return found


def _has_type(value: Any, name: str | list[str]) -> bool:
    names = [name] if isinstance(name, str) else name
    if isinstance(value, bool):
        return "boolean" in names
    return any(isinstance(value, _TYPES.get(one, object)) for one in names)


def _near(value: Any, choices: list[Any]) -> str:
    return did_you_mean(str(value), [choice for choice in choices if isinstance(choice, str)])


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + "..."
