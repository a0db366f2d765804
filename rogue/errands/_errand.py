"""Errands: what a user wants brought from where to where."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Errand:
    """A delivery: ``item`` for ``user`` from room ``pickup`` to room ``deliver``.

    Types of the domains: ``person``, ``item``, ``room``. One that goes ``back`` was given up
    while its item was on the tray; ``deliver`` is then where the item came from.
    """

    user: str
    item: str
    pickup: str
    deliver: str
    back: bool = False
