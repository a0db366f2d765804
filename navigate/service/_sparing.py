"""Keeps the log from filling up with one word."""

from __future__ import annotations

import math
import time
from enum import Enum

WORD_SECONDS = 60.0
"""Wall seconds between two words of one kind."""


class Sparing:
    """Allows a word of each kind once in `WORD_SECONDS`."""

    def __init__(self) -> None:
        self._said_at: dict[Enum, float] = {}

    def may_say(self, kind: Enum) -> bool:
        """Whether a word of this kind may be said now; if so, it counts as said."""
        now = time.monotonic()
        if now - self._said_at.get(kind, -math.inf) < WORD_SECONDS:
            return False
        self._said_at[kind] = now
        return True
