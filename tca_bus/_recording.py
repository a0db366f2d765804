"""Recordings: what passed on a realm, as an MCAP file.

Each message is in a channel of its own topic, as JSON with a JSON schema, so that viewers such as
Foxglove show it. Before it, in the channel ``tca/envelope`` and with the same sequence number,
stands what MCAP has no place for: the key, the attachment, and the payload itself where the JSON
is only a view of it. Both together are the message as it was.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import IO, Any

from mcap.writer import CompressionType, Writer
from pydantic import BaseModel, ConfigDict

from tca_bus._json_views import guessed_schema, json_view, plain_schema
from tca_bus._wire import Payload

PROFILE = "tca"
ENVELOPES = "tca/envelope"
BEGINNING = "tca.recording"
END = "tca.end"

CHUNK_SIZE = 1 << 20
"""Bytes after which a chunk is closed; a reader needs one at a time."""

SEQUENCES = 1 << 32
"""MCAP counts messages in 32 bits."""

DISTRIBUTION = "rogue-on-xavier"

PRESENCE = "presence"
TASK = "task"


@dataclass(frozen=True, slots=True)
class Passed:
    """Something that passed on the bus.

    ``key`` is without the realm. ``published`` and ``seen`` are nanoseconds since the epoch, by
    the sender's router and by the recorder. ``is_gone`` says that the key was deleted: a
    module's token vanished.
    """

    key: str
    payload: Payload
    attachment: bytes | None
    published: int
    seen: int
    is_gone: bool = False

    @property
    def topic(self) -> str:
        """The channel: the key, but one for all tasks of a sender and one for all presence."""
        kind, _, rest = self.key.partition("/")
        if kind == PRESENCE:
            return PRESENCE
        if kind == TASK:
            return f"{TASK}/{rest.partition('/')[0]}"
        return self.key

    @property
    def message(self) -> str:
        """What it says it is, such as ``xavierDrive@1``; empty when it does not say."""
        return self.payload.encoding.partition(";")[2]


class Envelope(BaseModel):
    """What stands beside a message; bytes that are no text are in base64."""

    model_config = ConfigDict(frozen=True)

    sequence: int
    key: str
    encoding: str
    attachment: str | None = None
    attachment64: str | None = None
    payload64: str | None = None
    is_gone: bool = False

    def restore(self, data: bytes, *, published: int, seen: int) -> Passed:
        """The message as it was; ``data`` is what its own channel holds."""
        original = base64.b64decode(self.payload64) if self.payload64 is not None else data
        attachment = self.attachment.encode() if self.attachment is not None else None
        if self.attachment64 is not None:
            attachment = base64.b64decode(self.attachment64)
        payload = Payload(original, self.encoding)
        return Passed(self.key, payload, attachment, published, seen, self.is_gone)


@dataclass
class RecordingWriter:
    """Writes a recording to a binary stream, in chunks; ``schemas`` are those known by name.

    What was flushed can be read whatever happens after that; `finish` adds the indexes that
    make it quick to open.
    """

    stream: IO[bytes]
    realm: str
    schemas: Mapping[str, dict[str, Any]]
    written: int = 0
    _channels: dict[tuple[str, str], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._writer = Writer(self.stream, chunk_size=CHUNK_SIZE, compression=CompressionType.ZSTD)
        self._writer.start(profile=PROFILE, library=f"{DISTRIBUTION} {version(DISTRIBUTION)}")
        self._writer.add_metadata(BEGINNING, {"realm": self.realm})
        schema = plain_schema(Envelope.model_json_schema(), "envelope")
        self._envelopes = self._register(ENVELOPES, "json", schema, {})

    @property
    def topics(self) -> int:
        """How many channels there are, but for that of the envelopes."""
        return len(self._channels)

    def write(self, passed: Passed) -> None:
        """Write one message."""
        view = json_view(passed.payload) if passed.payload.data else b"{}"
        data = passed.payload.data if view is None else view
        channel = self._channel(passed, view)
        self._add(self._envelopes, passed, self._envelope(passed, data))
        self._add(channel, passed, data)
        self.written += 1

    def flush(self) -> None:
        """Close the chunk and hand everything to the operating system."""
        self._writer.flush()

    def finish(self, dropped: int) -> None:
        """Write how many messages were lost before they came here, and the indexes."""
        self._writer.add_metadata(END, {"messages": str(self.written), "dropped": str(dropped)})
        self._writer.finish()
        self.stream.flush()

    def _add(self, channel: int, passed: Passed, data: bytes) -> None:
        self._writer.add_message(
            channel,
            log_time=passed.seen,
            publish_time=passed.published,
            data=data,
            sequence=self.written % SEQUENCES,
        )

    def _envelope(self, passed: Passed, data: bytes) -> bytes:
        attachment, text = passed.attachment, _text(passed.attachment)
        is_changed = data != passed.payload.data
        return (
            Envelope(
                sequence=self.written % SEQUENCES,
                key=passed.key,
                encoding=passed.payload.encoding,
                attachment=text,
                attachment64=_base64(attachment) if text is None and attachment else None,
                payload64=_base64(passed.payload.data) if is_changed else None,
                is_gone=passed.is_gone,
            )
            .model_dump_json(exclude_defaults=True)
            .encode()
        )

    def _channel(self, passed: Passed, view: bytes | None) -> int:
        encoding = "json" if view is not None else passed.payload.encoding or "unknown"
        key = (passed.topic, passed.payload.encoding if view is not None else encoding)
        if key not in self._channels:
            schema = None if view is None else self._schema(passed.message, view)
            about = {"encoding": passed.payload.encoding}
            self._channels[key] = self._register(passed.topic, encoding, schema, about)
        return self._channels[key]

    def _schema(self, message: str, view: bytes) -> dict[str, Any]:
        known = self.schemas.get(message)
        if known is not None:
            return plain_schema(known, message)
        return guessed_schema(view, message or "unknown")

    def _register(
        self, topic: str, encoding: str, schema: dict[str, Any] | None, about: dict[str, str]
    ) -> int:
        number = 0
        if schema is not None:
            data = json.dumps(schema).encode()
            number = self._writer.register_schema(schema["title"], "jsonschema", data)
        return self._writer.register_channel(topic, encoding, number, about)


def _text(data: bytes | None) -> str | None:
    try:
        return data.decode() if data is not None else None
    except UnicodeDecodeError:
        return None


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode()
