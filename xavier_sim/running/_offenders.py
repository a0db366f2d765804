"""Who sends what cannot be used: one word about each, until it sends something sound; pure rules.

``wall`` is seconds of any monotonic clock, handed in.
"""

from __future__ import annotations

import math

WORD_SECONDS = 60.0
"""Wall seconds between two words about one who is sound and not by turns."""


class Offenders:
    """Decides whether an offence is worth a word."""

    def __init__(self) -> None:
        self._named: set[str] = set()
        self._named_at: dict[str, float] = {}

    def offend(self, sender: str, wall: float) -> bool:
        """Something of a sender cannot be used; true when that is to be said."""
        recently = wall - self._named_at.get(sender, -math.inf) < WORD_SECONDS
        if sender in self._named or recently:
            return False
        self._named.add(sender)
        self._named_at[sender] = wall
        return True

    def clear(self, sender: str) -> None:
        """Something of a sender is sound again."""
        self._named.discard(sender)

    def forget(self, sender: str) -> None:
        """A sender is gone; one of its name that comes is another."""
        self._named.discard(sender)
        self._named_at.pop(sender, None)
