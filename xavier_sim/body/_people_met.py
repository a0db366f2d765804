"""Touches between a robot and people, counted apart, with how fast the robot came."""

from __future__ import annotations

from typing import Any

RELEASE_TICKS = 3
"""Control ticks without a touch after which the next one of the same person is a new one."""

HARMLESS = 0.1
"""A robot that comes towards somebody slower than this, in m/s, does no harm."""


class PeopleMet:
    """How often people were touched, and how hard.

    ``count`` are all touches, ``hits`` those in which the robot itself came towards the person
    faster than `HARMLESS`, ``hardest`` is the fastest of them, m/s.
    """

    def __init__(self) -> None:
        self.count, self.hits, self.hardest = 0, 0, 0.0
        self._since: dict[int, int] = {}

    @property
    def touched(self) -> list[int]:
        """Numbers of the people who were touched in the tick that ended last."""
        return [person for person, ticks in self._since.items() if ticks == 1]

    def pass_tick(self) -> None:
        """A control tick ends."""
        ticks = {person: since + 1 for person, since in self._since.items()}
        self._since = {person: since for person, since in ticks.items() if since <= RELEASE_TICKS}

    def touch(self, person: int, closing: float) -> None:
        """A person is touched by a robot that comes towards them at ``closing`` m/s."""
        if person not in self._since:
            self.count += 1
            self.hits += closing > HARMLESS
            self.hardest = max(self.hardest, closing)
        self._since[person] = 0

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs."""
        since = [[person, ticks] for person, ticks in self._since.items()]
        return {"count": self.count, "hits": self.hits, "hardest": self.hardest, "since": since}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.count, self.hits, self.hardest = state["count"], state["hits"], state["hardest"]
        self._since = dict(state["since"])
