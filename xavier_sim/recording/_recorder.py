"""Records a running robot into a file: takes what happens, and writes it on a thread."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Self

from pydantic import BaseModel

from tca_bus import TaskStatus
from xavier_sim.messages import Drive, Sensors, Standing, TrueLocation
from xavier_sim.recording._format import Beginning, RecordingFileError
from xavier_sim.recording._heard import Belief, Progress
from xavier_sim.recording._tape import Tape

FLUSH_SECONDS = 1.0
"""Wall seconds after which what happened is in the file: what a kill by force may cost."""

BATCH = 256
"""So many things are written at a time."""

MOST_SENSED = 4096
"""With so many things waiting to be written, the robot waits before its next tick."""

MOST_WAITING = 65_536
"""With so many waiting, what is neither sensors nor a command to the wheels is dropped."""

log = logging.getLogger(__name__)

Write = Callable[[], None]


class Recorder:
    """A witness of a robot: a context manager, from whose end on the file is complete.

    Sensors and commands are never lost: when the disk is too slow the robot waits for it. What
    else is said is dropped and counted when too much waits.

    Args:
        path: a file that is made, or replaced.
        beginning: how things stand at the first tick.
    """

    def __init__(self, path: Path, beginning: Beginning) -> None:
        self.path, self.dropped = path, 0
        self._beginning = beginning
        self._waiting: list[Write] = []
        self._written: Future[None] | None = None
        self._timer: asyncio.TimerHandle | None = None

    async def __aenter__(self) -> Self:
        """Begin the file.

        Raises:
            RecordingFileError: it cannot be made.
        """
        self._loop = asyncio.get_running_loop()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="recorder")
        try:
            await asyncio.wrap_future(self._thread.submit(self._open))
        except BaseException:
            self._thread.shutdown()
            raise
        self._timer = self._loop.call_later(FLUSH_SECONDS, self._flush)
        return self

    async def __aexit__(self, *_: object) -> None:
        """Complete the file, also when the robot ends for an error or is cancelled.

        Raises:
            RecordingFileError: it could not be written to its end.
        """
        if self._timer is not None:
            self._timer.cancel()
        batch, self._waiting = self._waiting, []
        last = self._thread.submit(self._finish, batch)
        try:
            await asyncio.shield(asyncio.wrap_future(last))
        finally:
            self._thread.shutdown()
        written = self._tape.written
        log.info("recorded %d records in %s, %d dropped", written, self.path, self.dropped)

    async def sense(
        self, sensors: Sensors, truth: TrueLocation, standing: Sequence[Standing] = ()
    ) -> None:
        """Record a tick; waits while too much is to be written.

        Raises:
            RecordingFileError: the file cannot be written any more.
        """
        tape = self._tape
        self._push(lambda: tape.sense(sensors, truth, standing))
        while len(self._waiting) >= MOST_SENSED or self._has_failed:
            self._submit()
            assert self._written is not None
            await asyncio.shield(asyncio.wrap_future(self._written))

    def note(self, message: BaseModel, time: float) -> None:
        """Record something that the robot said or did."""
        if isinstance(message, Drive) or self._has_room():
            self._push(lambda: self._tape.note(message, time))

    def believe(self, belief: Belief) -> None:
        """Record what the navigator believes."""
        if self._has_room():
            self._push(lambda: self._tape.believe(belief))

    def advance(self, progress: Progress) -> None:
        """Record how the drive under way goes."""
        if self._has_room():
            self._push(lambda: self._tape.advance(progress))

    def hear(self, status: TaskStatus) -> None:
        """Record the state of a task, as central published it."""
        if self._has_room():
            self._push(lambda: self._tape.hear(status))

    def miss(self, count: int) -> None:
        """Count messages that were lost on their way here."""
        self.dropped += count

    def _has_room(self) -> bool:
        if len(self._waiting) < MOST_WAITING:
            return True
        self.dropped += 1
        if self.dropped == 1:
            log.warning("the recording %s has gaps: the disk is too slow", self.path)
        return False

    @property
    def _has_failed(self) -> bool:
        done = self._written is not None and self._written.done()
        return done and self._written is not None and self._written.exception() is not None

    def _push(self, write: Write) -> None:
        self._waiting.append(write)
        if len(self._waiting) >= BATCH:
            self._submit()

    def _flush(self) -> None:
        self._timer = self._loop.call_later(FLUSH_SECONDS, self._flush)
        if self._waiting:
            self._submit()

    def _submit(self) -> None:
        """Hand what waits to the thread, unless it is still at work or has failed."""
        if self._written is None or (self._written.done() and not self._has_failed):
            batch, self._waiting = self._waiting, []
            self._written = self._thread.submit(self._write, batch)

    def _open(self) -> None:
        with self._told("cannot be made"):
            self._stream: IO[bytes] = self.path.open("wb")
            self._tape = Tape(self._stream, self._beginning)

    def _write(self, batch: list[Write]) -> None:
        with self._told("cannot be written any more"):
            for write in batch:
                write()
            self._tape.flush()

    def _finish(self, batch: list[Write]) -> None:
        try:
            if self._written is not None:
                self._written.result()
            self._write(batch)
            with self._told("cannot be written to its end"):
                self._tape.finish(dropped=self.dropped)
        finally:
            # What went wrong was told; closing would only fail for the same reason.
            with suppress(OSError):
                self._stream.close()

    @contextmanager
    def _told(self, why: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise RecordingFileError(self.path, f"{why} ({error.strerror or error})") from error
