"""What the navigator keeps on disk: roughly where it is, for when it is started again."""

from __future__ import annotations

import json
import logging
from pathlib import Path
from typing import Any

log = logging.getLogger(__name__)


class StateFile:
    """``navigate.json`` in the folder of what is kept; written whole, or not at all."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "navigate.json"

    def load(self) -> dict[str, Any] | None:
        """The state as it was last written; None when there is none that can be read."""
        try:
            state = json.loads(self.path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            log.warning("%s cannot be used: %s", self.path, error)
            return None
        if not isinstance(state, dict):
            log.warning("%s cannot be used: it holds no state", self.path)
            return None
        return state

    def save(self, state: dict[str, Any]) -> None:
        """Write the state; what was there stays until the new one is complete."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        beside = self.path.with_suffix(".json.new")
        beside.write_text(json.dumps(state), encoding="utf-8")
        beside.replace(self.path)
