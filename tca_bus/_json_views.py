"""Payloads and their schemas as other tools read them: strict JSON, and plain JSON schemas."""

from __future__ import annotations

import json
import math
from typing import Any

from tca_bus._errors import InvalidMessageError
from tca_bus._wire import FRAME_TYPE, Payload, decode_plain

ANYTHING: dict[str, Any] = {"type": "object"}


def json_view(payload: Payload) -> bytes | None:
    """A payload as strict JSON: arrays as lists, what is no finite number as null.

    None when it is neither JSON nor a frame. JSON that is strict already comes back as it is.
    """
    is_frame = payload.encoding.startswith(FRAME_TYPE)
    try:
        value = decode_plain(payload, "payload") if is_frame else json.loads(payload.data)
    except (InvalidMessageError, ValueError, RecursionError):
        return None
    if not is_frame and b"NaN" not in payload.data and b"Infinity" not in payload.data:
        return payload.data
    return json.dumps(_finite(value), allow_nan=False, ensure_ascii=False).encode()


def plain_schema(schema: dict[str, Any], title: str) -> dict[str, Any]:
    """A JSON schema without references and alternatives, which some viewers do not follow."""
    flat = _flat(schema, schema.get("$defs", {}), ())
    return {**ANYTHING, **flat, "title": title}


def guessed_schema(view: bytes, title: str) -> dict[str, Any]:
    """A schema that one sample suggests, for a message whose own schema nobody has told."""
    try:
        guessed = _guess(json.loads(view))
    except (ValueError, RecursionError):
        guessed = {}
    return {**ANYTHING, **guessed, "title": title, "description": "guessed from one sample"}


def _finite(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    return [_finite(item) for item in value] if isinstance(value, list) else value


def _flat(schema: Any, known: dict[str, Any], within: tuple[str, ...]) -> Any:
    if isinstance(schema, list):
        return [_flat(item, known, within) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        name = str(schema["$ref"]).rsplit("/", 1)[-1]
        # A type that holds itself cannot be written out.
        if name in within or name not in known:
            return dict(ANYTHING)
        return _flat(known[name], known, (*within, name))
    choices = schema.get("anyOf") or schema.get("oneOf") or schema.get("allOf")
    if choices:
        return _only_choice(choices, known, within)
    kept = {key: item for key, item in schema.items() if key not in {"$defs", "default"}}
    return {key: _flat(item, known, within) for key, item in kept.items()}


def _only_choice(choices: list[Any], known: dict[str, Any], within: tuple[str, ...]) -> Any:
    """What an optional value is when it is there; nothing is said of other alternatives."""
    real = [choice for choice in choices if choice != {"type": "null"}]
    return _flat(real[0], known, within) if len(real) == 1 else {}


def _guess(value: Any) -> dict[str, Any]:
    match value:
        case bool():
            return {"type": "boolean"}
        case int() | float():
            return {"type": "number"}
        case str():
            return {"type": "string"}
        case dict():
            fields = {key: _guess(item) for key, item in value.items()}
            return {"type": "object", "properties": fields}
        case list():
            return {"type": "array", "items": _guess(value[0]) if value else {}}
        case _:
            return {}
