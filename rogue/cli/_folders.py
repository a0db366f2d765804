"""Where things are kept when nobody says where."""

from __future__ import annotations

import os
from pathlib import Path


def default_folder(realm: str) -> Path:
    """The user's state folder for one robot, after the XDG base directory specification."""
    named = os.environ.get("XDG_STATE_HOME")
    base = Path(named) if named else Path.home() / ".local" / "state"
    return base / "rogue-on-xavier" / realm
