"""The channels of an MCAP file: each is made, with its schema, when it is first written to."""

from __future__ import annotations

import json
from typing import IO, Any

from google.protobuf.message import Message as Proto
from google.protobuf.wrappers_pb2 import BytesValue
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import build_file_descriptor_set

from tca_bus import Payload, json_view
from xavier_sim.recording._format import LIBRARY, PROFILE, SEQUENCES

CHUNK_SIZE = 1 << 18
"""Bytes after which a chunk is closed."""

ENCODING = "encoding"
"""Metadata of a channel: the encoding that its payloads had on the wire."""

FRAME = "application/x-tca-frame"


class Channels:
    """Writes records to a binary stream, each with the next number."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._writer = Writer(stream, chunk_size=CHUNK_SIZE, compression=CompressionType.ZSTD)
        self._writer.start(profile=PROFILE, library=LIBRARY)
        self._ids: dict[tuple[str, str], int] = {}
        self._schemas: dict[str, int] = {}
        self.written = 0

    def put_proto(self, topic: str, message: Proto, time: int) -> None:
        """Write a protobuf message; ``time`` is in nanoseconds."""
        kind = message.DESCRIPTOR.full_name
        if (topic, kind) not in self._ids:
            self._ids[topic, kind] = self._register_proto(topic, message, {})
        self._add(self._ids[topic, kind], message.SerializeToString(), time)

    def put_json(self, topic: str, data: bytes, schema: dict[str, Any], time: int) -> None:
        """Write strict JSON; the schema is that of the topic."""
        if (topic, "") not in self._ids:
            self._ids[topic, ""] = self._register_json(topic, schema, {})
        self._add(self._ids[topic, ""], data, time)

    def put_payload(self, topic: str, payload: Payload, schema: dict[str, Any], time: int) -> None:
        """Write a message as it was on the wire: JSON, or a frame's bytes in a protobuf value."""
        key, about = (topic, payload.encoding), {ENCODING: payload.encoding}
        is_frame = payload.encoding.startswith(FRAME)
        if key not in self._ids and is_frame:
            self._ids[key] = self._register_proto(topic, BytesValue(), about)
        elif key not in self._ids:
            self._ids[key] = self._register_json(topic, schema, about)
        data = BytesValue(value=payload.data).SerializeToString() if is_frame else payload.data
        self._add(self._ids[key], data, time)

    def put_metadata(self, name: str, values: dict[str, str]) -> None:
        """Write what is said about the recording as a whole."""
        self._writer.add_metadata(name, values)

    def flush(self) -> None:
        """Close the chunk and hand everything to the operating system."""
        self._writer.flush()
        self._stream.flush()

    def finish(self) -> None:
        """Write the indexes; nothing can be written after them."""
        self._writer.finish()
        self._stream.flush()

    def _add(self, channel: int, data: bytes, time: int) -> None:
        number = self.written % SEQUENCES
        self._writer.add_message(channel, time, data, publish_time=time, sequence=number)
        self.written += 1

    def _register_json(self, topic: str, schema: dict[str, Any], about: dict[str, str]) -> int:
        number = self._schema(schema["title"], "jsonschema", json.dumps(schema).encode())
        return self._writer.register_channel(topic, "json", number, about)

    def _register_proto(self, topic: str, message: Proto, about: dict[str, str]) -> int:
        described = build_file_descriptor_set(type(message)).SerializeToString()
        number = self._schema(message.DESCRIPTOR.full_name, "protobuf", described)
        return self._writer.register_channel(topic, "protobuf", number, about)

    def _schema(self, name: str, encoding: str, data: bytes) -> int:
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, encoding, data)
        return self._schemas[name]


def strict_json(payload: Payload) -> bytes:
    """JSON without the numbers that JSON does not have."""
    view = json_view(payload)
    return payload.data if view is None else view
