"""Reads recordings, finished or not, and tells what is wrong with a file that is none."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Self

import mcap.records as rec
from mcap.exceptions import McapError
from mcap.stream_reader import StreamReader
from pydantic import ValidationError
from zstandard import ZstdError

from tca_bus._errors import ConfigError, TcaError
from tca_bus._recording import BEGINNING, END, ENVELOPES, PROFILE, SEQUENCES, Envelope, Passed

LARGEST_RECORD = 1 << 30
"""Bytes; a longer record means that its length is damaged."""

UNREADABLE = (
    McapError,
    struct.error,
    ArithmeticError,
    LookupError,
    MemoryError,
    RuntimeError,
    ValueError,
    ZstdError,
)
"""What the reader of MCAP files ends with on one that is damaged."""

EXPECTED = "a recording made by 'tca record'"


class RecordingError(TcaError):
    """A recording cannot be read further, or not be written."""

    def __init__(self, path: Path, why: str) -> None:
        self.path, self.why = path, why
        super().__init__(f"recording {path}: {why}")


@dataclass
class RecordingReader:
    """Reads one recording from its beginning: a context manager and an iterator of `Passed`.

    After the last message ``is_finished`` says whether the recorder came to its end, and
    ``dropped`` how many messages it lost.

    Raises:
        ConfigError: On entering, it cannot be opened or is no recording.
        RecordingError: While iterating, it is damaged from here on.
    """

    path: Path
    realm: str = ""
    is_finished: bool = False
    dropped: int = 0
    _channels: dict[int, rec.Channel] = field(default_factory=dict)
    _envelope: Envelope | None = None
    _expected: int = 0

    def __enter__(self) -> Self:
        try:
            self._file: IO[bytes] = self.path.open("rb")
        except OSError as error:
            why = error.strerror or str(error)
            expected = f"a file that can be read ({why})"
            raise ConfigError("recording", str(self.path), expected) from None
        try:
            self._records = self._begin()
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __iter__(self) -> Iterator[Passed]:
        count = 0
        while True:
            try:
                passed = self._next()
            except UNREADABLE as error:
                if not self._file.read(1):
                    # Killed while it was being written: all before that is as it was.
                    return
                why = f"it is damaged after {count} messages ({_first_line(error)})"
                raise RecordingError(self.path, why) from error
            if passed is None:
                return
            count += 1
            yield passed

    def _begin(self) -> Iterator[Any]:
        reader = StreamReader(
            self._file, validate_crcs=True, record_size_limit=LARGEST_RECORD
        ).records
        try:
            header, beginning = next(reader), next(reader)
        except (*UNREADABLE, StopIteration) as error:
            raise ConfigError("recording", str(self.path), EXPECTED) from error
        if not isinstance(header, rec.Header) or header.profile != PROFILE:
            profile = getattr(header, "profile", "") or "none"
            expected = f"{EXPECTED}, not an MCAP file with profile {profile!r}"
            raise ConfigError("recording", str(self.path), expected)
        if not isinstance(beginning, rec.Metadata) or beginning.name != BEGINNING:
            raise ConfigError("recording", str(self.path), EXPECTED)
        self.realm = beginning.metadata.get("realm", "")
        return reader

    def _next(self) -> Passed | None:
        for record in self._records:
            match record:
                case rec.Channel():
                    self._channels[record.id] = record
                case rec.Message():
                    passed = self._message(record)
                    if passed is not None:
                        return passed
                case rec.Metadata(name=name) if name == END:
                    self.dropped = int(record.metadata.get("dropped", "0"))
                    self.is_finished = True
                case _:
                    pass
        return None

    def _message(self, record: rec.Message) -> Passed | None:
        channel = self._channels.get(record.channel_id)
        if channel is None:
            raise ValueError(f"channel {record.channel_id} is not there")
        if channel.topic == ENVELOPES:
            self._envelope = Envelope.model_validate_json(record.data)
            if self._envelope.sequence != self._expected:
                raise ValueError(f"message {self._expected} is not there")
            self._expected = (self._expected + 1) % SEQUENCES
            return None
        envelope, self._envelope = self._envelope, None
        if envelope is None or envelope.sequence != record.sequence:
            raise ValueError(f"message {record.sequence} has no envelope")
        return envelope.restore(record.data, published=record.publish_time, seen=record.log_time)


@dataclass
class RecordingInfo:
    """What is in a recording; times in nanoseconds since the epoch."""

    realm: str
    size: int
    is_finished: bool = False
    dropped: int = 0
    begin: int = 0
    end: int = 0
    topics: Counter[tuple[str, str]] = field(default_factory=Counter)

    @property
    def seconds(self) -> float:
        """From the first message to the last."""
        return (self.end - self.begin) / 1e9


def read_info(path: Path) -> RecordingInfo:
    """Look through a recording.

    Raises:
        ConfigError: It cannot be opened or is none.
        RecordingError: It is damaged.
    """
    with RecordingReader(path) as reader:
        info = RecordingInfo(reader.realm, path.stat().st_size)
        for passed in reader:
            info.begin = info.begin or passed.seen
            info.end = passed.seen
            info.topics[passed.topic, passed.message] += 1
        info.is_finished, info.dropped = reader.is_finished, reader.dropped
    return info


def _first_line(error: BaseException) -> str:
    if isinstance(error, ValidationError):
        return "an envelope cannot be read"
    return (str(error) or type(error).__name__).splitlines()[0]
