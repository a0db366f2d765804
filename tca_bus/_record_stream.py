"""The records of an MCAP file, finished or cut off, and what is wrong with one that is damaged."""

from __future__ import annotations

import struct
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import mcap.records as rec
from mcap.exceptions import McapError
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from tca_bus._errors import TcaError

LARGEST_RECORD = 1 << 30
"""Bytes; a longer record means that its length is damaged."""

_DAMAGED = (
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


class UnreadableError(TcaError):
    """A file is no MCAP file, or damaged; ``why`` says in a few words where it fails."""

    def __init__(self, path: Path, why: str) -> None:
        self.path, self.why = path, why
        super().__init__(f"{path} cannot be read as an MCAP file: {why}")


class RecordStream:
    """The messages and metadata of an MCAP file in their order: a context manager and an iterator.

    A file that was cut off, since its recorder was killed, ends where the last whole chunk does.

    Args:
        path: of the file.
        end: name of the metadata that the recorder writes at last, with what it has ``dropped``.

    ``profile`` is the file's; ``channels``, by their number, are those met so far, and that of each
    message is among them. After the last record ``is_finished`` says whether the recorder came to
    its end, and ``dropped`` how many messages it lost.

    Raises:
        OSError: On entering, it cannot be opened.
        UnreadableError: On entering, it is no MCAP file; while iterating, it is damaged from here.
    """

    def __init__(self, path: Path, *, end: str) -> None:
        self.path = path
        self.profile = ""
        self.channels: dict[int, rec.Channel] = {}
        self.is_finished, self.dropped = False, 0
        self._end = end

    def __enter__(self) -> Self:
        self._file = self.path.open("rb")
        reader = StreamReader(self._file, validate_crcs=True, record_size_limit=LARGEST_RECORD)
        self._records: Iterator[Any] = reader.records
        try:
            self.profile = self._header().profile
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> rec.Message | rec.Metadata:
        while (record := self._read()) is not None:
            match record:
                case rec.Channel():
                    self.channels[record.id] = record
                case rec.Message():
                    if record.channel_id not in self.channels:
                        why = f"channel {record.channel_id} is not there"
                        raise UnreadableError(self.path, why)
                    return record
                case rec.Metadata(name=name) if name == self._end:
                    self._finish(record.metadata.get("dropped", "0"))
                case rec.Metadata():
                    return record
                case _:
                    pass
        raise StopIteration

    def _header(self) -> rec.Header:
        header = self._read()
        if not isinstance(header, rec.Header):
            raise UnreadableError(self.path, "it has no header")
        return header

    def _read(self) -> Any:
        """The next record; None at the end, and where the file was cut off."""
        try:
            return next(self._records, None)
        except _DAMAGED as error:
            if not self._file.read(1):
                # Killed while it was being written: all before that is as it was.
                return None
            why = (str(error) or type(error).__name__).splitlines()[0]
            raise UnreadableError(self.path, why) from error

    def _finish(self, dropped: str) -> None:
        if not dropped.isdecimal():
            raise UnreadableError(self.path, f"dropped is {dropped!r}, expected a number")
        self.is_finished, self.dropped = True, int(dropped)


class RecordFile(ABC):
    """A recording that is read from its beginning: a context manager; its kind says what is in it.

    After the last record ``is_finished`` says whether the recorder came to its end, and ``dropped``
    how many messages it lost.

    Args:
        path: of the file.
        end: as of `RecordStream`.
    """

    def __init__(self, path: Path, *, end: str) -> None:
        self.path = path
        self._records = RecordStream(path, end=end)

    @property
    def is_finished(self) -> bool:
        """Whether the end has been read, as the recorder wrote it."""
        return self._records.is_finished

    @property
    def dropped(self) -> int:
        """How many messages the recorder lost, by what it wrote at its end."""
        return self._records.dropped

    def __enter__(self) -> Self:
        try:
            with ExitStack() as stack:
                stack.enter_context(self._records)
                self._begin()
                stack.pop_all()
        except (OSError, UnreadableError) as error:
            raise self._unusable(error) from error
        return self

    def __exit__(self, *error: object) -> None:
        self._records.__exit__(*error)

    @abstractmethod
    def _begin(self) -> None:
        """Read how the recording begins."""

    @abstractmethod
    def _unusable(self, error: OSError | UnreadableError) -> TcaError:
        """What to say of a file that cannot be opened, or is no recording."""
