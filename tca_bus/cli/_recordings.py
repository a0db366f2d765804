"""The work behind ``tca record`` and ``tca replay``."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import IO

from tca_bus import ConfigError
from tca_bus._recorder import Recorder
from tca_bus._recording_reader import RecordingInfo, RecordingReader, read_info
from tca_bus._replayer import Remap, Replayer, parse_speed
from tca_bus._selection import Selection
from tca_bus.cli._client import joined
from tca_bus.cli._flags import BusFlags
from tca_bus.cli._output import emit, emit_json, note, show_table


async def write_recording(
    file: Path, keys: Sequence[str], *, duration: float | None, force: bool, flags: BusFlags
) -> None:
    """Record into a file for so many wall seconds, or until cancelled.

    Raises:
        ConfigError: The file cannot be made, or one of the keys is none.
        RecordingError: The file cannot be written any more.
    """
    selection = Selection.parse(keys)
    async with joined(flags) as module:
        with _new_file(file, force=force) as stream:
            recorder = Recorder(module, file, stream, selection, on_drop=_note_dropped)
            note(f"recording realm {module.options.realm} to {file}; Ctrl-C ends it")
            begin = time.monotonic()
            try:
                await recorder.run(duration)
            except asyncio.CancelledError:
                # An interrupt is how a recording ends; what it has is complete.
                if (task := asyncio.current_task()) is not None:
                    task.uncancel()
            _sum_up(recorder, time.monotonic() - begin, flags)


async def replay_recording(
    file: Path,
    *,
    speed: str,
    keys: Sequence[str],
    remap: Sequence[str],
    skip: float,
    presence: bool,
    flags: BusFlags,
) -> None:
    """Replay a file to its end.

    Raises:
        ConfigError: It is no recording, or one of the options cannot be used.
        RecordingError: It is damaged.
    """
    pace, rules, selection = parse_speed(speed), Remap.parse(remap), Selection.parse(keys)
    with RecordingReader(file) as reader:
        async with joined(flags) as module:
            here = module.options.realm
            note(f"replaying {file}, recorded on realm {reader.realm}, on realm {here}")
            replayer = Replayer(module, selection, rules, pace, skip, presence)
            await replayer.run(reader)
        if not reader.is_finished:
            note("the recording was cut off; all that is in it was replayed")
        if flags.json:
            emit_json({"messages": replayer.sent})
        else:
            emit(f"replayed {replayer.sent:,} messages")


def show_info(file: Path, flags: BusFlags) -> None:
    """Say what is in a file.

    Raises:
        ConfigError: It is no recording.
        RecordingError: It is damaged.
    """
    _show_info(read_info(file), flags)


@contextmanager
def _new_file(path: Path, *, force: bool) -> Iterator[IO[bytes]]:
    try:
        stream = path.open("wb" if force else "xb")
    except FileExistsError:
        expected = "a file that is not there yet; --force writes over it"
        raise ConfigError("FILE", str(path), expected) from None
    except OSError as error:
        expected = f"a file that can be written ({error.strerror})"
        raise ConfigError("FILE", str(path), expected) from None
    with stream:
        yield stream


def _note_dropped(count: int) -> None:
    note(f"{count:,} messages were dropped so far: the disk is too slow")


def _sum_up(recorder: Recorder, seconds: float, flags: BusFlags) -> None:
    size = recorder.path.stat().st_size
    facts = {
        "file": str(recorder.path),
        "messages": recorder.writer.written,
        "topics": recorder.writer.topics,
        "seconds": round(seconds, 3),
        "bytes": size,
        "dropped": recorder.dropped,
        "outages": recorder.module.outages,
    }
    if flags.json:
        emit_json(facts)
        return
    emit(
        f"recorded {facts['messages']:,} messages on {facts['topics']} topics in {seconds:.1f} s "
        f"to {recorder.path} ({_bytes(size)}), {recorder.dropped:,} dropped"
    )
    if recorder.module.outages:
        note(f"the router was away {recorder.module.outages} times; what passed then is missing")


def _show_info(info: RecordingInfo, flags: BusFlags) -> None:
    topics = [
        {"topic": topic, "message": message, "messages": count}
        for (topic, message), count in sorted(info.topics.items())
    ]
    if flags.json:
        emit_json(
            {
                "realm": info.realm,
                "begin": info.begin / 1e9,
                "seconds": info.seconds,
                "bytes": info.size,
                "messages": info.topics.total(),
                "dropped": info.dropped,
                "finished": info.is_finished,
                "topics": topics,
            }
        )
        return
    begin = datetime.fromtimestamp(info.begin / 1e9).astimezone().isoformat(sep=" ")
    ending = f"{info.dropped:,} dropped" if info.is_finished else "cut off before its end"
    emit(f"realm {info.realm}, from {begin}, {info.seconds:.1f} s, {_bytes(info.size)}, {ending}")
    show_table(["topic", "message", "count"], [list(topic.values()) for topic in topics])


def _bytes(count: float) -> str:
    for unit in ("bytes", "kB", "MB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} GB"
