"""Where the file behind ``--config`` is."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path


def config_path(tokens: Sequence[str], environ: Mapping[str, str] = os.environ) -> Path | None:
    """Find the file that ``--config`` or ``TCA_CONFIG`` names, if any does."""
    for number, word in enumerate(tokens):
        if word == "--":
            break
        if word.startswith("--config="):
            return Path(word.removeprefix("--config="))
        if word == "--config" and number + 1 < len(tokens):
            return Path(tokens[number + 1])
    named = environ.get("TCA_CONFIG")
    return Path(named) if named else None
