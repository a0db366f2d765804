"""Reads recordings, finished or cut off, and tells what is wrong with a file that is none."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Self

import mcap.records as rec
from google.protobuf.message import DecodeError
from google.protobuf.wrappers_pb2 import BytesValue
from mcap.exceptions import McapError
from mcap.stream_reader import StreamReader
from pydantic import ValidationError
from zstandard import ZstdError

from tca_bus import Payload
from xavier_sim.recording._channels import ENCODING, FRAME
from xavier_sim.recording._format import (
    BEGINNING,
    END,
    FORMAT,
    PROFILE,
    SEQUENCES,
    WIRE,
    Beginning,
    Entry,
    RecordingFileError,
)

LARGEST_RECORD = 1 << 30
"""Bytes; a longer record means that its length is damaged."""

DAMAGED = (
    McapError,
    struct.error,
    ArithmeticError,
    LookupError,
    MemoryError,
    RuntimeError,
    ValueError,
    ZstdError,
    DecodeError,
)
"""What the reader of MCAP files ends with on one that is damaged."""


@dataclass
class RecordingReader:
    """Reads one recording: a context manager and an iterator of the messages on the wire.

    After the last one ``is_finished`` says whether the recorder came to its end, and ``dropped``
    how many messages it lost.

    Raises:
        RecordingFileError: On entering, it cannot be opened or is no recording; while iterating,
            it is damaged from here on.
    """

    path: Path
    is_finished: bool = False
    dropped: int = 0
    _channels: dict[int, rec.Channel] = field(default_factory=dict)
    _next: int = 0

    def __enter__(self) -> Self:
        try:
            self._file: IO[bytes] = self.path.open("rb")
        except OSError as error:
            why = f"cannot be opened ({error.strerror or error})"
            raise RecordingFileError(self.path, why) from None
        try:
            self.beginning = self._begin()
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __iter__(self) -> Iterator[Entry]:
        while (message := self._read()) is not None:
            channel = self._channels[message.channel_id]
            if channel.topic.startswith(WIRE):
                name = channel.topic.removeprefix(WIRE)
                yield Entry(
                    name, self._payload(channel, message), message.log_time, message.sequence
                )

    def _begin(self) -> Beginning:
        reader = StreamReader(self._file, validate_crcs=True, record_size_limit=LARGEST_RECORD)
        self._records: Iterator[Any] = reader.records
        try:
            header = next(self._records)
        except (*DAMAGED, StopIteration) as error:
            raise RecordingFileError(self.path, "is no MCAP file") from error
        if not isinstance(header, rec.Header) or header.profile != PROFILE:
            raise RecordingFileError(self.path, _wrong_profile(getattr(header, "profile", "")))
        first = self._read()
        if first is None:
            raise RecordingFileError(self.path, "is cut off before its first message")
        if self._channels[first.channel_id].topic != BEGINNING:
            raise RecordingFileError(self.path, "does not begin as a recording does")
        return self._beginning(first.data)

    def _beginning(self, data: bytes) -> Beginning:
        try:
            beginning = Beginning.model_validate_json(data)
        except ValidationError as error:
            where = ".".join(str(part) for part in error.errors()[0]["loc"])
            why = f"does not begin as a recording does: {where} does not fit"
            raise RecordingFileError(self.path, why) from error
        if beginning.format != FORMAT:
            why = f"has format {beginning.format}, expected {FORMAT}"
            raise RecordingFileError(self.path, why)
        return beginning

    def _read(self) -> rec.Message | None:
        """The next message; None at the end, and where the file was cut off."""
        try:
            return self._next_message()
        except DAMAGED as error:
            if not self._file.read(1):
                # Killed while it was being written: all before that is as it was.
                return None
            said = (str(error) or type(error).__name__).splitlines()[0]
            why = f"is damaged after {self._next} records ({said})"
            raise RecordingFileError(self.path, why) from error

    def _next_message(self) -> rec.Message | None:
        for record in self._records:
            match record:
                case rec.Channel():
                    self._channels[record.id] = record
                case rec.Message():
                    self._check(record)
                    return record
                case rec.Metadata(name=name) if name == END:
                    self.dropped = int(record.metadata.get("dropped", "0"))
                    self.is_finished = True
                case _:
                    pass
        return None

    def _check(self, message: rec.Message) -> None:
        if message.channel_id not in self._channels:
            raise ValueError(f"channel {message.channel_id} is not there")
        if message.sequence != self._next % SEQUENCES:
            raise ValueError(f"record {self._next} is not there")
        self._next += 1

    def _payload(self, channel: rec.Channel, message: rec.Message) -> Payload:
        encoding = channel.metadata.get(ENCODING, "")
        if not encoding.startswith(FRAME):
            return Payload(message.data, encoding)
        try:
            return Payload(BytesValue.FromString(message.data).value, encoding)
        except DecodeError as error:
            why = f"has a record {message.sequence} that is no frame"
            raise RecordingFileError(self.path, why) from error


def _wrong_profile(profile: str) -> str:
    hint = "; 'tca replay' plays it" if profile == "tca" else ""
    return f"is no recording of this robot: its profile is {profile!r}, not {PROFILE!r}{hint}"
