"""Recorded events as JSON, for the journal."""

from __future__ import annotations

from typing import get_args

from tca_bus._event_codec import EventCodec
from tca_bus.tasktree._events import RecordedEvent

_CODEC: EventCodec[RecordedEvent] = EventCodec(get_args(RecordedEvent))

encode_event = _CODEC.encode
decode_event = _CODEC.decode
