"""A soak on disk, from which another process goes on with it bit for bit."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from xavier_sim.snapshots import SnapshotError, write_atomically
from xavier_sim.soak._cost import Cost
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._soak import Soak

FORMAT = 3

START_ANEW = "give the options that it was begun with, or another file"
ANOTHER = "move it away, or give another file"


class CheckpointFile:
    """A file that holds the state of a soak between two jobs, and what it has cost so far."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def save(self, soak: Soak, cost: Cost) -> None:
        """Replace what the file holds.

        Raises:
            SnapshotError: it cannot be written.
        """
        document = {
            "format": FORMAT,
            "options": soak.options.model_dump(mode="json"),
            "cost": asdict(cost),
            "soak": soak.snapshot(),
        }
        write_atomically(self.path, json.dumps(document))

    def load(self, soak: Soak) -> Cost | None:
        """Put a new soak into the state that the file holds; None when there is no such file.

        Raises:
            SnapshotError: the file is damaged, or of a soak with other options.
        """
        if not self.path.exists():
            return None
        document = self._read()
        self._check(document, soak.options)
        try:
            soak.restore(document["soak"])
            return Cost(**document["cost"])
        except (AttributeError, LookupError, TypeError, ValueError) as error:
            raise SnapshotError(self.path, f"is damaged ({error!r})", ANOTHER) from error

    def _read(self) -> dict[str, Any]:
        try:
            document = json.loads(self.path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise SnapshotError(self.path, "is no checkpoint of a soak", ANOTHER) from error
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise SnapshotError(self.path, f"is no checkpoint of format {FORMAT}", ANOTHER)
        return document

    def _check(self, document: dict[str, Any], options: SoakOptions) -> None:
        try:
            kept = SoakOptions.model_validate(document.get("options"))
        except ValidationError as error:
            raise SnapshotError(self.path, "names no options of a soak", ANOTHER) from error
        for name, (ours, theirs) in options.differences(kept).items():
            why = f"is of a soak with {name} {theirs!r}, not {ours!r}"
            raise SnapshotError(self.path, why, START_ANEW)
