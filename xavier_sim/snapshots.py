"""The world on disk, from which it goes on after the process was killed."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from tca_bus import TcaError

FORMAT = 1


ELSEWHERE = "move it away, or give another --data folder"


class SnapshotError(TcaError, ValueError):
    """A file that keeps something cannot be used. ``why`` is a half-sentence about it."""

    exit_code = 2

    def __init__(self, file: Path, why: str, remedy: str = ELSEWHERE) -> None:
        self.file, self.why = file, why
        super().__init__(f"{file} {why}; {remedy}")


class Saved(BaseModel):
    """A world and its time.

    ``clock_start`` is the time of tick 0, seconds since the epoch. ``tick_limit`` is a tick that
    the process will not pass before it has saved again: one that is restarted after a crash
    begins behind it, so that time never goes back. ``stopped`` says that the process ended with
    this very world, so that nobody has heard of a later tick. ``reflexes`` has the states of the
    robots' own reflexes, by name.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: int = FORMAT
    clock_start: float
    tick_limit: int
    world: dict[str, Any]
    stopped: bool = False
    reflexes: dict[str, dict[str, Any]] = {}


def write_atomically(path: Path, text: str) -> None:
    """Write a file so that a reader, or a kill in between, sees the old one or the new one.

    Raises:
        SnapshotError: it cannot be written.
    """
    if not path.name:
        raise SnapshotError(path, "is no file", "give the name of one")
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    except OSError as error:
        why = f"cannot be written ({error.strerror})"
        raise SnapshotError(path, why, "give a folder that can be") from error


class SnapshotFile:
    """``xavier.json`` in the data folder."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "xavier.json"

    def save(self, saved: Saved) -> None:
        """Replace the snapshot."""
        write_atomically(self.path, saved.model_dump_json())

    def load(self, *, floor: str) -> Saved | None:
        """The snapshot, None when there is none yet.

        Raises:
            SnapshotError: it is damaged, or of another floor or format.
        """
        if not self.path.exists():
            return None
        try:
            saved = Saved.model_validate_json(self.path.read_bytes())
        except (OSError, ValidationError) as error:
            raise SnapshotError(self.path, "is no snapshot of a world") from error
        if saved.format != FORMAT:
            raise SnapshotError(self.path, f"has format {saved.format}, expected {FORMAT}")
        if saved.world.get("floor") != floor:
            other = saved.world.get("floor")
            raise SnapshotError(self.path, f"is of floor {other!r}, expected {floor!r}")
        return saved
