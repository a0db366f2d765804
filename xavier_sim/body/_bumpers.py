"""Bump panels: contacts of the physics, debounced into panels pressed and bumps counted."""

from __future__ import annotations

import math
from collections.abc import Iterable

from xavier_sim.body._physics import Contact
from xavier_sim.messages import BUMP_PANELS

PANEL = 2.0 * math.pi / BUMP_PANELS

RELEASE_TICKS = 3
"""Control ticks without any contact after which the next one counts as a new bump."""


class Bumpers:
    """Turns the contacts of a control tick into panels, and counts separate bumps."""

    def __init__(self) -> None:
        self.count = 0
        self.free_ticks = RELEASE_TICKS

    def feel(self, contacts: Iterable[Contact], theta: float) -> tuple[int, bool]:
        """The panels pressed in this tick as bits, and whether a new bump began."""
        panels = 0
        for contact in contacts:
            panels |= 1 << (round((contact.direction - theta) / PANEL) % BUMP_PANELS)
        if not panels:
            self.free_ticks = min(self.free_ticks + 1, RELEASE_TICKS)
            return 0, False
        began = self.free_ticks >= RELEASE_TICKS
        self.free_ticks = 0
        self.count += began
        return panels, began

    def snapshot(self) -> dict[str, int]:
        """Everything that `restore` needs."""
        return {"count": self.count, "free_ticks": self.free_ticks}

    def restore(self, state: dict[str, int]) -> None:
        """Go back to a snapshot."""
        self.count, self.free_ticks = state["count"], state["free_ticks"]
