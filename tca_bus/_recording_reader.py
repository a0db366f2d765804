"""Reads recordings, finished or not, and tells what is wrong with a file that is none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import mcap.records as rec
from pydantic import ValidationError

from tca_bus._errors import ConfigError, TcaError
from tca_bus._record_stream import RecordFile, UnreadableError
from tca_bus._recording import BEGINNING, END, ENVELOPES, PROFILE, SEQUENCES, Envelope, Passed

EXPECTED = "a recording made by 'tca record'"


class RecordingError(TcaError):
    """A recording cannot be read further, or not be written."""

    def __init__(self, path: Path, why: str) -> None:
        self.path, self.why = path, why
        super().__init__(f"recording {path}: {why}")


class RecordingReader(RecordFile):
    """Reads one recording from its beginning: a context manager and an iterator of `Passed`.

    After the last message ``is_finished`` says whether the recorder came to its end, and
    ``dropped`` how many messages it lost.

    Raises:
        ConfigError: On entering, it cannot be opened or is no recording.
        RecordingError: While iterating, it is damaged from here on.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, end=END)
        self.realm = ""
        self._envelope: Envelope | None = None
        self._expected = 0

    def __iter__(self) -> Iterator[Passed]:
        count = 0
        try:
            for record in self._records:
                if isinstance(record, rec.Message) and (passed := self._message(record)):
                    count += 1
                    yield passed
        except UnreadableError as error:
            why = f"it is damaged after {count} messages ({error.why})"
            raise RecordingError(self.path, why) from error

    def _begin(self) -> None:
        profile = self._records.profile
        if profile != PROFILE:
            expected = f"{EXPECTED}, not an MCAP file with profile {profile or 'none'!r}"
            raise ConfigError("recording", str(self.path), expected)
        beginning = next(self._records, None)
        if not isinstance(beginning, rec.Metadata) or beginning.name != BEGINNING:
            raise ConfigError("recording", str(self.path), EXPECTED)
        self.realm = beginning.metadata.get("realm", "")

    def _unusable(self, error: OSError | UnreadableError) -> ConfigError:
        expected = EXPECTED
        if isinstance(error, OSError):
            expected = f"a file that can be read ({error.strerror or error})"
        return ConfigError("recording", str(self.path), expected)

    def _message(self, record: rec.Message) -> Passed | None:
        """What passed; None for an envelope, whose message comes next."""
        if self._records.channels[record.channel_id].topic == ENVELOPES:
            self._envelope = self._open(record.data)
            return None
        envelope, self._envelope = self._envelope, None
        if envelope is None or envelope.sequence != record.sequence:
            raise UnreadableError(self.path, f"message {record.sequence} has no envelope")
        try:
            return envelope.restore(
                record.data, published=record.publish_time, seen=record.log_time
            )
        except ValueError as error:
            why = f"the envelope of message {record.sequence} does not fit"
            raise UnreadableError(self.path, why) from error

    def _open(self, data: bytes) -> Envelope:
        try:
            envelope = Envelope.model_validate_json(data)
        except ValidationError as error:
            raise UnreadableError(self.path, "an envelope cannot be read") from error
        if envelope.sequence != self._expected:
            raise UnreadableError(self.path, f"message {self._expected} is not there")
        self._expected = (self._expected + 1) % SEQUENCES
        return envelope


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
