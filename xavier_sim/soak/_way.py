"""How doors stood for a time: open, shut, or the one and then the other."""

from __future__ import annotations

import enum


class Way(enum.StrEnum):
    """Whether a way was open for a time: to a goal while the robot drove, or through a door."""

    OPEN = "open"
    """At all times."""
    SHUT = "shut"
    """At no time."""
    CHANGING = "changing"
    """At some times, so that both arriving and giving up are right."""
