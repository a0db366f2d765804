"""Recorded events as JSON, for the journal."""

from __future__ import annotations

from typing import get_args

from pydantic import TypeAdapter
from pydantic_core import to_json

from tca_bus.tasktree._events import RecordedEvent

_KINDS: dict[str, TypeAdapter[RecordedEvent]] = {
    kind.__name__: TypeAdapter(kind) for kind in get_args(RecordedEvent)
}


def encode_event(event: RecordedEvent) -> tuple[str, str]:
    """Give the kind of an event and its fields as JSON."""
    kind = type(event).__name__
    return kind, to_json(event, inf_nan_mode="constants").decode()


def decode_event(kind: str, body: str) -> RecordedEvent:
    """Rebuild an event.

    Raises:
        ValueError: There is no such kind, or the fields do not fit it.
    """
    adapter = _KINDS.get(kind)
    if adapter is None:
        raise ValueError(f"unknown kind of event {kind!r}, expected one of {', '.join(_KINDS)}")
    return adapter.validate_json(body)
