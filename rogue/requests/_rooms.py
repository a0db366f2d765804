"""Rooms as people write them."""

from __future__ import annotations

import re
from collections.abc import Collection

_WORD = re.compile(r"[a-z0-9]+(?:[-_][a-z0-9]+)*")


def room_name(text: str | None) -> str | None:
    """A room as the map names it: ``5303`` and ``R-5303`` are ``r-5303``; None for nothing."""
    if text is None or not text.strip():
        return None
    name = text.strip().lower()
    return f"r-{name}" if name.isdigit() else name


def room_in(text: str, rooms: Collection[str]) -> str | None:
    """The first room that is named in ``text``: of ``Wean Hall 5313, x8-2611`` it is ``r-5313``."""
    for word in _WORD.findall(text.lower()):
        name = room_name(word)
        if name in rooms:
            return name
    return None
