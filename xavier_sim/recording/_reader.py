"""Reads recordings, finished or cut off, and tells what is wrong with a file that is none."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mcap.records as rec
from google.protobuf.message import DecodeError
from google.protobuf.wrappers_pb2 import BytesValue
from pydantic import ValidationError

from tca_bus import Payload, RecordFile, UnreadableError
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


class RecordingReader(RecordFile):
    """Reads one recording: a context manager and an iterator of the messages on the wire.

    After the last one ``is_finished`` says whether the recorder came to its end, and ``dropped``
    how many messages it lost.

    Raises:
        RecordingFileError: On entering, it cannot be opened or is no recording; while iterating,
            it is damaged from here on.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, end=END)
        self._next = 0

    def __iter__(self) -> Iterator[Entry]:
        while (message := self._read()) is not None:
            channel = self._records.channels[message.channel_id]
            if channel.topic.startswith(WIRE):
                name = channel.topic.removeprefix(WIRE)
                yield Entry(
                    name, self._payload(channel, message), message.log_time, message.sequence
                )

    def _unusable(self, error: OSError | UnreadableError) -> RecordingFileError:
        if isinstance(error, OSError):
            why = f"cannot be opened ({error.strerror or error})"
            return RecordingFileError(self.path, why)
        return RecordingFileError(self.path, "is no MCAP file")

    def _begin(self) -> None:
        if self._records.profile != PROFILE:
            raise RecordingFileError(self.path, _wrong_profile(self._records.profile))
        first = self._read()
        if first is None:
            raise RecordingFileError(self.path, "is cut off before its first message")
        if self._records.channels[first.channel_id].topic != BEGINNING:
            raise RecordingFileError(self.path, "does not begin as a recording does")
        self.beginning = self._beginning(first.data)

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
            for record in self._records:
                if isinstance(record, rec.Message):
                    self._check(record)
                    return record
        except UnreadableError as error:
            why = f"is damaged after {self._next} records ({error.why})"
            raise RecordingFileError(self.path, why) from error
        return None

    def _check(self, message: rec.Message) -> None:
        if message.sequence != self._next % SEQUENCES:
            raise UnreadableError(self.path, f"record {self._next} is not there")
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
