"""Which modules are on the bus, as a pure table: tokens and transport events in, changes out.

When the router is lost all liveliness tokens vanish at once, so a vanished token alone says
nothing about its module: the entry becomes a suspect, and is lost only when it has not come back
after a grace, during which the way to the router was open.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

VANISH_GRACE = 1.0
"""Wall seconds from a vanished token to a lost module: covers a transport event that comes late
and a module that lost and reopened its own link."""

RECONNECT_GRACE = 3.0
"""Wall seconds after a reconnect until modules that have not announced themselves again are
lost; they retry once a second."""


@dataclass(frozen=True, slots=True)
class PresentModule:
    """A module on the bus, as its liveliness token names it.

    ``incarnation`` is new with each start and sorts by start time; ``provides`` are the wire
    names of the messages that it handles.
    """

    name: str
    incarnation: str
    host: str
    pid: int
    provides: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PresenceChange:
    """A module came or changed what it provides (``appeared``), or is gone for good (not)."""

    module: PresentModule
    appeared: bool


class PresenceTable:
    """The modules that are there, and those that may be gone.

    ``own`` is the incarnation of the module that keeps the table; it is never suspected. Times
    are seconds of any monotonic clock.
    """

    def __init__(self, own: str = "") -> None:
        self._own = own
        self._entries: dict[str, PresentModule] = {}
        self._suspects: dict[str, float] = {}
        self._reachable = True
        # Looked up for every message that is sent; emptied whenever something changes.
        self._named: dict[str, PresentModule] = {}
        self._providers: dict[str, list[PresentModule]] = {}

    def modules(self) -> list[PresentModule]:
        """All that are not lost, by name and incarnation."""
        return sorted(self._entries.values(), key=lambda entry: (entry.name, entry.incarnation))

    def put(self, module: PresentModule) -> list[PresenceChange]:
        """A token appeared."""
        self._forget_look_ups()
        self._suspects.pop(module.incarnation, None)
        known = self._entries.get(module.incarnation)
        self._entries[module.incarnation] = module
        return [] if known == module else [PresenceChange(module, appeared=True)]

    def delete(self, module: PresentModule, now: float) -> None:
        """A token vanished; one that its module has replaced is of no interest."""
        if self._entries.get(module.incarnation) == module and module.incarnation != self._own:
            due = now + VANISH_GRACE if self._reachable else math.inf
            self._suspects.setdefault(module.incarnation, due)
            self._forget_look_ups()

    def router_lost(self, *, is_direct: bool = False) -> None:
        """The transport closed: everybody else is suspect until it is back.

        With direct links only those are whose tokens vanish.
        """
        self._reachable = False
        hidden = self._suspects if is_direct else self._entries
        self._suspects = {key: math.inf for key in hidden if key != self._own}
        self._forget_look_ups()

    def router_back(self, now: float) -> None:
        """The transport opened: suspects have a grace to announce themselves."""
        self._reachable = True
        self._suspects = dict.fromkeys(self._suspects, now + RECONNECT_GRACE)

    def next_expiry(self) -> float:
        """When `expire` has something to do; infinity for never."""
        return min(self._suspects.values(), default=math.inf)

    def expire(self, now: float) -> list[PresenceChange]:
        """Give up suspects whose grace is over."""
        lost = [key for key, due in self._suspects.items() if due <= now]
        for key in lost:
            del self._suspects[key]
        self._forget_look_ups()
        return [PresenceChange(self._entries.pop(key), appeared=False) for key in lost]

    def state_of(self, incarnation: str) -> bool | None:
        """True when present, None when suspect, False when lost or never seen."""
        if incarnation in self._suspects:
            return None
        return incarnation in self._entries

    def named(self, name: str) -> PresentModule | None:
        """The newest incarnation of a module, suspect or not."""
        found = self._named.get(name)
        if found is None:
            found = _newest(entry for entry in self._entries.values() if entry.name == name)
            if found is not None:
                self._named[name] = found
        return found

    def providers(self, message: str) -> list[PresentModule]:
        """The newest incarnation of each module that handles ``message``, certain ones first."""
        found = self._providers.get(message)
        if found is None:
            found = self._look_up_providers(message)
            # Only names that are served are kept: anything may be asked for.
            if found:
                self._providers[message] = found
        return list(found)

    def _look_up_providers(self, message: str) -> list[PresentModule]:
        newest: dict[str, PresentModule] = {}
        for entry in self._entries.values():
            known = newest.get(entry.name)
            if known is None or known.incarnation < entry.incarnation:
                newest[entry.name] = entry
        found = [entry for entry in newest.values() if message in entry.provides]
        return sorted(found, key=lambda entry: (entry.incarnation in self._suspects, entry.name))

    def has_provider(self, message: str) -> bool:
        """Whether a module that handles ``message`` is there for certain."""
        return any(entry.incarnation not in self._suspects for entry in self.providers(message))

    def known_messages(self) -> set[str]:
        """All wire names that somebody handles."""
        return {name for entry in self._entries.values() for name in entry.provides}

    def _forget_look_ups(self) -> None:
        self._named.clear()
        self._providers.clear()


def _newest(entries: Iterable[PresentModule]) -> PresentModule | None:
    return max(entries, key=lambda entry: entry.incarnation, default=None)
