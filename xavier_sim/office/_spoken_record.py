"""What was said and answered, by task: so that a task that is sent again is not done again."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from xavier_sim.office._things import Things
from xavier_sim.snapshots import SnapshotError, write_atomically

KEPT = 1000
"""Tasks that are remembered; older ones are not sent again."""


class Done(BaseModel):
    """The outcome of a task: the text said, or the answer given, and when."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    text: str
    time: float


class Record(BaseModel):
    """Outcomes by task id, and how often each question was asked.

    ``numbers`` has, for a task whose question is still open, the how-manieth asking it is;
    ``sent`` the rooms whose people were sent out (False) or in.
    """

    model_config = ConfigDict(extra="forbid")

    done: dict[str, Done] = {}
    asked: dict[str, int] = {}
    numbers: dict[str, int] = {}
    things: Things = Things()
    sent: dict[str, bool] = {}

    def number(self, task: str, question: str) -> int:
        """The how-manieth asking of its question a task is; the same when it is sent again."""
        if task not in self.numbers:
            self.asked[question] = self.asked.get(question, 0) + 1
            self.numbers[task] = self.asked[question]
        return self.numbers[task]

    def finish(self, task: str, outcome: Done) -> None:
        """Remember an outcome, and forget the oldest."""
        self.done[task] = outcome
        self.numbers.pop(task, None)
        for table in (self.done, self.asked, self.numbers):
            while len(table) > KEPT:
                del table[next(iter(table))]


class RecordFile:
    """``speech.json`` in the data folder; with no folder it remembers while the process lives."""

    def __init__(self, folder: Path | None) -> None:
        self.path = folder / "speech.json" if folder is not None else None
        self.record = self._load()

    def save(self) -> None:
        """Put the record on disk."""
        if self.path is not None:
            write_atomically(self.path, self.record.model_dump_json())

    def _load(self) -> Record:
        if self.path is None or not self.path.exists():
            return Record()
        try:
            return Record.model_validate_json(self.path.read_bytes())
        except (OSError, ValidationError) as error:
            raise SnapshotError(self.path, "is no record of the speech board") from error
