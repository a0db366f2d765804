"""The folder in which everything is kept."""

from __future__ import annotations

import os
from pathlib import Path

from tca_bus import ConfigError


def default_folder(realm: str) -> Path:
    """The user's state folder for one robot, after the XDG base directory specification."""
    named = os.environ.get("XDG_STATE_HOME")
    base = Path(named) if named else Path.home() / ".local" / "state"
    return base / "rogue-on-xavier" / realm


def make_folder(folder: Path) -> Path:
    """Make a folder unless it is there.

    Raises:
        ConfigError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        expected = f"a folder that can be made and written ({error.strerror})"
        raise ConfigError("--data", str(folder), expected) from error
    return folder
