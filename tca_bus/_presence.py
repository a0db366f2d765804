"""Which modules are on the bus."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PresentModule:
    """A module on the bus, as its liveliness token names it."""

    name: str
    incarnation: str
    host: str
    pid: int
    provides: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PresenceChange:
    """A module came (``appeared``) or is gone for good (not ``appeared``)."""

    module: PresentModule
    appeared: bool
