"""What handlers really did, in a file of their own: one line per deed, whoever is killed."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path


class Deed(StrEnum):
    """What a handler did with one attempt."""

    BEGUN = "begun"
    DONE = "done"
    FAILED = "failed"
    STOPPED = "stopped"


@dataclass(frozen=True)
class Entry:
    """One line; ``time`` is the machine's monotonic clock, the same for all its processes."""

    deed: Deed
    task: str
    attempt: int
    module: str
    pid: int
    time: float


class Ledger:
    """A file that many processes append to; a line is there whole or not at all."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def note(self, deed: Deed, task: str, attempt: int, module: str) -> None:
        """Append one line in one write, which no kill can cut."""
        entry = Entry(deed, task, attempt, module, os.getpid(), time.monotonic())
        line = json.dumps(asdict(entry)) + "\n"
        file = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            os.write(file, line.encode())
        finally:
            os.close(file)

    def entries(self) -> Iterator[Entry]:
        """All lines, in the order in which they were written."""
        if not self._path.exists():
            return
        for line in self._path.read_text(encoding="utf-8").splitlines():
            facts = json.loads(line)
            yield Entry(**{**facts, "deed": Deed(facts["deed"])})
